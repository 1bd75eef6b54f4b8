"""Seconds per stage of the warm pipeline, for every example: median of N runs in one process.

python bench/stages.py [RUNS] [MODEL...]
"""

from __future__ import annotations

import statistics
import sys
from pathlib import Path

from app.pipeline import classify, mesh, read, write_deck

EXAMPLES = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.csg"))


def main() -> None:
    arguments = sys.argv[1:]
    runs = int(arguments.pop(0)) if arguments and arguments[0].isdigit() else 5
    models = [Path(argument) for argument in arguments] or EXAMPLES
    header_done = False
    for model in models:
        rows: list[dict[str, float]] = []
        for _ in range(runs + 1):
            meshed = mesh(classify(read(str(model))))
            write_deck(meshed, "model.bdf")
            rows.append(meshed.seconds)
        stages = list(rows[0])
        if not header_done:
            print(f"{'milliseconds':28}" + "".join(f"{stage:>10}" for stage in [*stages, "total"]))
            header_done = True
        medians = [1e3 * statistics.median(row[stage] for row in rows[1:]) for stage in stages]
        print(f"{model.name:28}" + "".join(f"{value:10.1f}" for value in [*medians, sum(medians)]))


if __name__ == "__main__":
    main()
