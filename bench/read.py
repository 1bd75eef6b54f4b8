"""Seconds to read an OpenSCAD file of N leaves (default 10,000): median of 5.

python bench/read.py [LEAVES]
"""

from __future__ import annotations

import statistics
import sys
import time

from kernel.csg.reader import read_model

LEAF = """\tmultmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {
\t\tcylinder($fn = 0, $fa = 12, $fs = 2, h = 10, r1 = 1, r2 = 1, center = false);
\t}
"""


def main() -> None:
    leaves = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    text = "union() {\n" + LEAF * leaves + "}\n"
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        read_model(text, "bench.csg")
        seconds.append(time.perf_counter() - start)
    print(f"{leaves} leaves, {len(text) / 1e6:.1f} MB: {statistics.median(seconds):.2f} s")


if __name__ == "__main__":
    main()
