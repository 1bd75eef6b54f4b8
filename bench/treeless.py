"""How many labelled models keep their exact answer when the tree is thrown away.

    python bench/treeless.py [FOLDER] [NAME...]        FOLDER holds *.csg and expected.json; tests/cases by default

The evaluated solid, with its tracked surfaces, is decided as if it were one leaf. Beside it stands the answer with the
tree. Prints the models that differ, with what came out, and how many stay exact.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "segment"))

from segmenting import is_answer, told  # noqa: E402

from kernel.csg.reader import read_file  # noqa: E402
from kernel.segment.partition import Partition, partition  # noqa: E402
from kernel.solid.evaluate import evaluate  # noqa: E402
from rules.engine import RuleBase, load_rule_base  # noqa: E402

WAYS = {"with the tree": True, "treeless": False}


def main(arguments: list[str]) -> None:
    """Count, and name what differs."""
    folder = ROOT / "tests" / "cases"
    if arguments and Path(arguments[0]).is_dir():
        folder = Path(arguments.pop(0))
    expected = json.loads((folder / "expected.json").read_text(encoding="utf-8"))
    names = arguments or sorted(expected)
    base = load_rule_base()
    exact: Counter[str] = Counter()
    for name in names:
        for way, use_tree in WAYS.items():
            found = _decided(folder / f"{name}.csg", base, use_tree)
            if is_answer(expected[name]["answer"], found):
                exact[way] += 1
            else:
                print(f"{name}, {way}:\n  expected {_wanted(expected[name]['answer'])}\n  found    {told(found)}")
    for way in WAYS:
        print(f"{way}: {exact[way]} of {len(names)} exact")


def _decided(path: Path, base: RuleBase, use_tree: bool) -> Partition:
    return partition(evaluate(read_file(str(path))), base.decide, use_tree=use_tree)


def _wanted(answer: list[dict]) -> str:
    return "; ".join(
        f"{item['type']}({', '.join(f'{name} {value}' for name, value in item.items() if name != 'type')})"
        for item in answer
    )


if __name__ == "__main__":
    main(sys.argv[1:])
