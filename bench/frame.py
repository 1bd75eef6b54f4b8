"""A frame of touching members, from text to deck: seconds by stage.

python bench/frame.py [MEMBERS]      1,000 by default; the figure asked for is under 15 s
"""

from __future__ import annotations

import sys
import time

from app.pipeline import classify, mesh, write_deck
from kernel.csg.reader import read_model


def frame(bays: int) -> str:
    """A floor of bays x bays columns of 40 x 40 x 960, with beams of 40 x 40 on them both ways."""
    solids = []
    for i in range(bays):
        for j in range(bays):
            if i < bays - 1 or j < bays - 1:  # no beam begins at the last corner
                solids.append(f"(BLO(40, 40, 960) AT (MOVX={1000 * i}, MOVY={1000 * j}))")
            if i < bays - 1:
                solids.append(f"(BLO(1000, 40, 40) AT (MOVX={1000 * i}, MOVY={1000 * j}, MOVZ=960))")
            if j < bays - 1:
                solids.append(f"(BLO(40, 1000, 40) AT (MOVX={1000 * i}, MOVY={1000 * j}, MOVZ=960))")
    return "FRAME = " + " UN &\n".join(solids) + "\nOUT FRAME\n"


def main() -> None:
    members = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    bays = next(n for n in range(2, 1000) if n * n + 2 * n * (n - 1) >= members)
    text = frame(bays)
    start = time.perf_counter()
    meshed = mesh(classify(read_model(text, "frame.csg")))
    middle = time.perf_counter()
    deck = write_deck(meshed, "frame.bdf")
    end = time.perf_counter()
    stages = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in meshed.seconds.items())
    print(f"{len(meshed.model.properties)} segments, {meshed.checks.components} component, {len(deck):,} bytes")
    print(
        f"{stages}, write {end - middle:.2f}; all {end - start:.2f} s; {'; '.join(meshed.checks.failures) or 'checked'}"
    )


if __name__ == "__main__":
    main()
