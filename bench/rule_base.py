"""What a rule base costs: loading and compiling, a distinct node, an equal node. CPU milliseconds, median.

    python bench/rule_base.py [NODES]

The nodes are random, so that every rule is tried and none of them can be answered from the cache.
"""

from __future__ import annotations

import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from kernel.facts import SPECS, TIERS, VOCABULARY, Facts, Value
from kernel.plan import Need
from rules.engine import RuleBase, load_rule_base, rule_base_from_text

N_RULE = 100
EMPTY = Facts({}, TIERS[-1])


def hundred_rules() -> str:
    """A base of N_RULE rules: three conditions each over random facts and twenty parameters."""
    random_ = random.Random(1)
    names = [spec.name for spec in VOCABULARY if spec.dimension == "ratio"]
    lines = ["name: hundred", "parameters:"]
    lines += [f"  p{index}: {{value: {index / 3 + 0.1:.3f}, unit: 1}}" for index in range(20)]
    lines.append("rules:")
    for index in range(N_RULE - 1):
        a, b, c = random_.sample(names, 3)
        band, type_ = random_.choice(["general", "specific"]), random_.choice(["beam", "plate", "plates", "split"])
        lines += [
            f"  - id: r{index}",
            f"    priority: {band}",
            f"    when: [{a} >= p{random_.randrange(20)}, {{any: [{b} < 0.5, not: is_prismatic]}}, {c} <= p9]",
            f"    then: {{segment: {type_}, certainty: 0.{random_.randint(1, 9)}, because: 'it is {{{a}:.1f}}'}}",
        ]
    lines.append("  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: none}}")
    return "\n".join(lines)


def random_node(random_: random.Random) -> Facts:
    """All facts of a node, measured to the last tier."""
    values: dict[str, Value] = {}
    for spec in VOCABULARY:
        if spec.dimension == "boolean":
            values[spec.name] = random_.random() < 0.5
        elif spec.dimension == "text":
            values[spec.name] = random_.choice(spec.choices)
        elif spec.dimension == "count":
            values[spec.name] = random_.randrange(6)
        else:
            values[spec.name] = random_.random() * 6.0
    return Facts(values, TIERS[-1])


def tier_by_tier(base: RuleBase, facts: Facts) -> None:
    """Ask as the kernel does: from cheap to dear, until there is a conclusion."""
    tier = TIERS[0]
    while True:
        reached = TIERS.index(tier)
        known = {name: value for name, value in facts.items() if TIERS.index(SPECS[name].tier) <= reached}
        answer = base.decide(Facts(known, tier))
        if not isinstance(answer, Need):
            return
        tier = answer.tier


def report(what: str, work: Sequence[Any], action: Callable[[Any], object]) -> None:
    """Print the median CPU time of `action` over the items of `work`."""
    times = []
    for item in work:
        start = time.process_time()
        action(item)
        times.append(time.process_time() - start)
    print(f"{what:50}{statistics.median(times) * 1e3:9.3f} ms")


def cold_load(_: int) -> float:
    """Seconds of a new process for importing the engine and loading the own base."""
    code = "from time import process_time as t; s = t(); import rules.engine as e; e.load_rule_base(); print(t() - s)"
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def main() -> None:
    """All figures."""
    n_node = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    text = hundred_rules()
    print(f"{'own base: import and load, cold':50}{statistics.median(map(cold_load, range(5))) * 1e3:9.3f} ms")
    rule_base_from_text(text).decide(Facts({}, TIERS[-1]))
    report("100 rules: load", range(5), lambda _: rule_base_from_text(text))
    report("100 rules: load, compile, first answer", range(5), lambda _: rule_base_from_text(text).decide(EMPTY))
    random_ = random.Random(2)
    nodes = [random_node(random_) for _ in range(n_node)]
    for name, base in (("100 rules", rule_base_from_text(text)), ("own base", load_rule_base())):
        base.decide(EMPTY)
        report(f"{name}: a distinct node, all facts known", nodes, base.decide)
        report(f"{name}: an equal node", nodes, base.decide)
        again = RuleBase(base.definition)
        again.decide(EMPTY)
        report(f"{name}: a distinct node, asked tier by tier", nodes, partial(tier_by_tier, again))
        report(f"{name}: an explanation in full, as text", nodes[:100], partial(explained, base))


def explained(base: RuleBase, facts: Facts) -> str:
    """The full explanation of one node."""
    return base.explain(facts).to_text()


if __name__ == "__main__":
    main()
