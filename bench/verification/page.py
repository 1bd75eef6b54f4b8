"""The page that shows the cases."""

from __future__ import annotations

from verification.cases import ALL, Row

HEAD = """# Verification

Every model here is a CSG text that went through csgmesh; the numbers are what MYSTRAN and CalculiX printed. Written by
`make verification`; do not edit. "limit" is the difference that we allow; a number outside it is marked.

Material: E = 210,000 MPa, nu = 0.3, 7.85e-9 t/mm3. Freedoms: six at nodes of beams and shells, three at the others.
"""

EXPLANATIONS = {
    "cantilevers": "CalculiX's beams are single brick elements inside, their hollow sections integrated at a few "
    "points and their shear flexibility that of the brick: a thin box comes out some 2 % stiff.",
    "tees": "Extended webs count half of each flange twice, which stiffens the long beam by 2.5 % (its second moment "
    "of area by 2.8 %); by arms it is within 0.3 %. The short beam is as much sheared as bent: with the web's whole "
    "height as its shear area, 120 x 8 instead of the section's own, the reference is 5 % stiffer, and the five "
    "differences at 360 read +4.0, +4.0, +5.2, +4.8 and +3.8 %. This case alone: "
    "`PYTHONPATH=bench python -m verification tees`.",
    "pipes": "CalculiX's PIPE section has the same limit: its shear flexibility is too small, which a pipe as short as "
    "four diameters shows.",
    "table": "An averaged foot does not stiffen the top over the leg's section, as the solid does: some 2 % soft, "
    "where a rigid foot is some 7 % stiff. CalculiX's S4, a brick of incompatible modes, is stiffer at this size "
    "and hides it. The reference is CalculiX's own solution of the quadratic bricks.",
    "bracket": "Mid-surfaces of walls in a corner are longer than the walls by half a thickness each: the plates are "
    "softer, by what the thickness makes of it.",
}
"""What a reader should know of a case whose numbers are outside their limits, or nearly so."""


def page(found: dict[str, list[Row]]) -> str:
    lines = [HEAD]
    for case in ALL:
        if case.__name__ not in found:
            continue
        lines.append(f"\n## {case.__name__.replace('_', ' ').capitalize()}\n")
        lines.append(" ".join((case.__doc__ or "").split()) + "\n")
        lines.append("| case | quantity | as | solver | found | reference | differs | limit | freedoms |")
        lines.append("|---|---|---|---|---:|---:|---:|---:|---:|")
        lines += [_line(row) for row in found[case.__name__]]
        notes = list(dict.fromkeys(row.note for row in found[case.__name__] if row.note))
        lines += [f"\n{note}" for note in notes]
        if case.__name__ in EXPLANATIONS:
            lines.append(f"\n{EXPLANATIONS[case.__name__]}")
    return "\n".join(lines) + "\n"


def _line(row: Row) -> str:
    if row.value is None:
        found, differs = "refused", "-"
    else:
        found, differs = f"{row.value:.5g}", f"{row.error:+.2%}" + ("" if row.holds else " **outside**")
    return (
        f"| {row.case} | {row.quantity} | {row.representation} | {row.solver} | {found} | {row.reference:.5g} "
        f"| {differs} | {row.limit:.1%} | {row.freedoms:,} |"
    )
