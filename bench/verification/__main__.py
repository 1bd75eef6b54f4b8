"""Run every case and write docs/verification.md:  python -m verification  (with bench/ on the path)."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from verification.common import Row
from verification.page import EXPLANATIONS, page
from verification.suite import ALL

PAGE = Path(__file__).resolve().parents[2] / "docs" / "verification.md"


def main() -> None:
    wanted = sys.argv[1:]
    found: dict[str, list[Row]] = {}
    for case in ALL:
        if wanted and case.__name__ not in wanted:
            continue
        start = time.perf_counter()
        found[case.__name__] = list(case())
        for row in found[case.__name__]:
            error = "" if row.error is None else f"{row.error:+.2%}"
            print(row.case, row.quantity, row.representation, row.solver, row.value, row.reference, error, row.note)
        print(f"-- {case.__name__}: {time.perf_counter() - start:.1f} s", flush=True)
    if not wanted:
        PAGE.write_text(page(found))
    failures = [row for name, group in found.items() for row in group if not row.holds and name not in EXPLANATIONS]
    sys.exit(f"{len(failures)} numbers outside their limits, unexplained" if failures else 0)


main()
