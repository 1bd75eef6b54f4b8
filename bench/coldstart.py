"""Whole-process time and peak memory of command lines, from a cold start: median of N runs.

    python bench/coldstart.py [RUNS]

The first run of each command is not counted: it warms the file cache, not the process.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COMMANDS = (
    "csgmesh --help",
    "csgmesh tree examples/table.csg",
    "csgmesh classify examples/table.csg",
    "csgmesh mesh examples/table.csg -o {out}/table.bdf",
    "csgmesh mesh examples/plate_with_holes.csg -o {out}/plate.bdf",
    "csgmesh mesh examples/bracket.csg -o {out}/bracket.bdf",
)


def run(command: list[str]) -> tuple[float, float]:
    """Wall seconds and peak resident megabytes of one run; its output is thrown away."""
    start = time.perf_counter()
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    message = process.stderr.read().decode() if process.stderr else ""
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{' '.join(command)} failed: {message}")
    return seconds, usage.ru_maxrss / 1024


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    program = str(Path(sys.executable).with_name("csgmesh"))
    print(f"{'command':64} {'min':>6} {'median':>7} {'max':>6} s  {'peak MB':>7}")
    with tempfile.TemporaryDirectory() as folder:
        for text in COMMANDS:
            words = text.format(out=folder).split()
            measured = [run([program, *words[1:]]) for _ in range(runs + 1)][1:]
            seconds = [second for second, _ in measured]
            peak = max(memory for _, memory in measured)
            low, middle, high = min(seconds), statistics.median(seconds), max(seconds)
            print(f"{text.format(out='OUT'):64} {low:6.2f} {middle:7.2f} {high:6.2f}    {peak:7.0f}")


if __name__ == "__main__":
    main()
