"""CPU seconds and peak memory of deciding and splitting, for the models whose size users ask about.

    python bench/segments.py [NAME...]          all, or some of: lattice overlap egg_crate holes corpus rules

Each row runs in a process of its own (peak memory is its own), the median of 3 runs for the small ones.
"""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from kernel.connect.contacts import find_joints
from kernel.csg.reader import read_file
from kernel.csg.tree import Block, Boolean, CsgModel, CsgNode, Cylinder
from kernel.facts import VOCABULARY, Facts
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate
from rules.engine import load_rule_base

CORPUS = sorted((Path(__file__).resolve().parent.parent / "tests" / "cases").glob("*.csg"))


def block(size: tuple[float, float, float], corner: tuple[float, float, float]) -> Block:
    placement = np.eye(4)
    placement[:3, 3] = corner
    return Block(size=size, placement=placement)


def model(root: CsgNode) -> CsgModel:
    return CsgModel(root=root, source="bench", language="json", units="mm")


def union(members: list[CsgNode]) -> CsgModel:
    return model(Boolean(operation="union", children=tuple(members)))


def lattice(n: int, overlap: bool = False) -> CsgModel:
    """A frame of n^3 cells, side 1000, square bars of 40.

    Touching: columns run through, bars end at their faces. Overlapping: bars run from axis to axis.
    """
    pitch, width = 1000.0, 40.0
    inset = 0.0 if overlap else width
    members: list[CsgNode] = []
    for i in range(n + 1):
        for j in range(n + 1):
            x, y = i * pitch, j * pitch
            members.append(block((width, width, n * pitch + width), (x, y, 0.0)))
            for k in range(n + 1):
                z = k * pitch
                if i < n:
                    members.append(block((pitch - inset + (width - inset), width, width), (x + inset, y, z)))
                if j < n:
                    members.append(block((width, pitch - inset + (width - inset), width), (x, y + inset, z)))
    return union(members)


def egg_crate(n: int) -> CsgModel:
    """A closed box of n x n cells: floor and crossing walls, all of thickness 4."""
    pitch, t, height = 60.0, 4.0, 50.0
    length = n * pitch + t
    members: list[CsgNode] = [block((length, length, t), (0.0, 0.0, 0.0))]
    for i in range(n + 1):
        members.append(block((t, length, height), (i * pitch, 0.0, 0.0)))
        members.append(block((length, t, height), (0.0, i * pitch, 0.0)))
    return union(members)


def drilled(n: int) -> CsgModel:
    """A plate with n x n holes."""
    pitch, t = 50.0, 8.0
    tools: list[CsgNode] = []
    for i in range(n):
        for j in range(n):
            placement = np.eye(4)
            placement[:3, 3] = ((i + 0.5) * pitch, (j + 0.5) * pitch, -1.0)
            tools.append(Cylinder(radius=10.0, height=t + 2.0, placement=placement))
    plate = block((n * pitch, n * pitch, t), (0.0, 0.0, 0.0))
    return model(Boolean(operation="difference", children=(plate, *tools)))


def segmented(csg: CsgModel) -> dict[str, object]:
    """CPU seconds of each stage, and what came out."""
    base = load_rule_base()
    marks = [time.process_time()]
    evaluated = evaluate(csg)
    marks.append(time.process_time())
    parts = partition(evaluated, base.decide, {})
    marks.append(time.process_time())
    joints = find_joints(parts.segments, evaluated)
    marks.append(time.process_time())
    seconds = dict(zip(("evaluate", "segment", "joints"), np.diff(marks).round(3).tolist()))
    types = Counter(segment.type for segment in parts.segments)
    return {"operands": len(csg.root.operands), **seconds, "segments": dict(types), "n_joint": len(joints)}


def corpus() -> dict[str, object]:
    """Warm milliseconds of `partition` over the labelled models of the tests."""
    base = load_rule_base()
    milliseconds = []
    for path in CORPUS:
        evaluated = evaluate(read_file(str(path)))
        partition(evaluated, base.decide, {})
        evaluated = evaluate(read_file(str(path)))
        start = time.perf_counter()
        partition(evaluated, base.decide, {})
        milliseconds.append(1e3 * (time.perf_counter() - start))
    return {"models": len(CORPUS), "median_ms": round(statistics.median(milliseconds), 1), "max_ms": max(milliseconds)}


def rules() -> dict[str, object]:
    """Loading and compiling the base, and deciding distinct nodes with every fact known."""
    start = time.perf_counter()
    base = load_rule_base()
    loading = time.perf_counter() - start
    generator = np.random.default_rng(1)
    questions = []
    for _ in range(2000):
        values: dict[str, object] = {}
        for spec in VOCABULARY:
            if spec.dimension == "text":
                values[spec.name] = spec.choices[int(generator.integers(len(spec.choices)))]
            elif spec.dimension == "boolean":
                values[spec.name] = bool(generator.integers(2))
            elif spec.dimension == "count":
                values[spec.name] = int(generator.integers(5))
            else:
                values[spec.name] = float(generator.lognormal(0.0, 2.0))
        questions.append(Facts(values, "necks"))  # type: ignore[arg-type]
    start = time.perf_counter()
    for question in questions:
        base.decide(question)
    return {"load_s": round(loading, 3), "ms_per_node": 1e3 * (time.perf_counter() - start) / len(questions)}


CASES: dict[str, Callable[[], dict[str, object]]] = {
    "lattice 100": lambda: segmented(lattice(3)),
    "lattice 1000": lambda: segmented(lattice(7)),
    "lattice 10000": lambda: segmented(lattice(16)),
    "overlap 1000": lambda: segmented(lattice(7, overlap=True)),
    "overlap 10000": lambda: segmented(lattice(16, overlap=True)),
    "egg_crate 256": lambda: segmented(egg_crate(16)),
    "holes 400": lambda: segmented(drilled(20)),
    "corpus": corpus,
    "rules": rules,
}


def main() -> None:
    if len(sys.argv) == 3 and sys.argv[1] == "--one":
        row = CASES[sys.argv[2]]()
        row["peak_MB"] = round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
        print(json.dumps(row))
        return
    wanted = sys.argv[1:]
    for name in CASES:
        if not wanted or name.split()[0] in wanted:
            done = subprocess.run(
                [sys.executable, __file__, "--one", name], capture_output=True, text=True, check=False
            )
            print(f"{name:14}", done.stdout.strip() or done.stderr.strip().splitlines()[-1], flush=True)


if __name__ == "__main__":
    main()
