"""Analysis for the authors of rules: is a rule base sound, do its cases pass, what do they cover, what would it change.

check(path)              names, units, unreachable, shadowed and contradictory rules, gaps
run_cases(base)          every case of the base
coverage(base)           which conditions the cases exercise both ways
diff(a, b, nodes)        which nodes two bases decide differently
vocabulary_text(base)    the facts, the parameters and the rules, as documentation

Every report has to_text(), to_json() and `ok`.
"""

from rules.analysis.cases import CaseReport, run_cases
from rules.analysis.check import CheckReport, check, check_base, check_text
from rules.analysis.coverage import CoverageReport, coverage
from rules.analysis.diff import DiffReport, diff, diff_plans
from rules.analysis.docs import vocabulary_json, vocabulary_text

__all__ = [
    "CaseReport",
    "CheckReport",
    "CoverageReport",
    "DiffReport",
    "check",
    "check_base",
    "check_text",
    "coverage",
    "diff",
    "diff_plans",
    "run_cases",
    "vocabulary_json",
    "vocabulary_text",
]
