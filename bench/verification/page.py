"""The page that shows the cases."""

from __future__ import annotations

from verification.common import Row
from verification.suite import ALL

HEAD = """# Verification

Every model here is a CSG text that went through csgmesh; the numbers are what MYSTRAN and CalculiX printed. Written by
`make verification`; do not edit. "limit" is the difference that we allow; a number outside it is marked.

Material: E = 210,000 MPa, nu = 0.3, 7.85e-9 t/mm3. Freedoms: six at nodes of beams and shells, three at the others.
"""

EXPLANATIONS = {
    "cantilevers": "Plates that are carried on to one another's mid-surfaces count the web twice within the flanges "
    "(+2.3 % of the area of the I): too stiff; with `--tee arms` the web stops at the flange. CalculiX takes BOX "
    "and PIPE for B32R only, which are bricks inside and shear over their whole area, not over the webs: theory "
    "says -1.13 % for this box, and refined from 50 to 10 mm ccx comes to -1.26 %. No other choice of element or "
    "section does better; the deck's head names a beam for which it is more than 1 %.",
    "tees": "Extended webs count half of each flange twice, which stiffens the long beam by 2.5 % (its second moment "
    "of area by 2.8 %); by arms it is within 0.3 %. The short beam is as much sheared as bent: with the web's whole "
    "height as its shear area, 120 x 8 instead of the section's own, the reference is 5 % stiffer, and the five "
    "differences at 360 read +4.0, +4.0, +5.2, +4.8 and +3.8 %. This case alone: "
    "`PYTHONPATH=bench python -m verification tees`.",
    "pipes": "CalculiX's PIPE shears over its whole area too: at four diameters of length theory says -4.7 %.",
    "halves": "What is left is the hexes' bending at 10 mm, and that the clamped root cannot contract: at 5 mm all "
    "three couplings are within 1 %, see below.",
    "joint_stress": "Work is shared out as beam theory has the stresses; at a distance all three agree.",
    "stiffener": "A bar as a line has no width: the plate's fields reach from the rim to the bar's middle, 200 mm, "
    "where the solid bar leaves them 196 mm. That makes the mixed models some 3 % soft, however fine. CalculiX "
    "ties a beam to a plate by knots, which hold every section between them from contracting: strip and plate come "
    "out stiff at 20 mm, less so at 10 mm.",
    "fin": "The root of a thick plate turns within the block, as if the plate were 0.44 of its thickness longer "
    "(O'Donnell, J. Appl. Mech. 27, 1960): 3 x 0.44 x 6 / 120 = 6.6 % here. Bricks twice as large as the plate is "
    "thick do not show it; bricks of half its thickness do. The coupling has no say in it.",
    "boss": "The plate's normals stay straight up to the boss's rim, where in the solid they turn within the boss: "
    "the same root as of the plate on a block, of 0.44 x 12 mm in 90. It comes in only as the bricks get finer.",
    "table": "The mean of the contact (distributing, work) leaves the top as soft over a leg as elsewhere: a bound "
    "from below on the stiffness, +4 % of sag when refined. A rigid contact is a bound from above, some -6 % when "
    "refined. The truth lies between, for the leg stiffens the top but is itself elastic. At the automatic 50 mm "
    "the error of the mesh and that of the foot stand against one another.",
    "bracket": "Mid-surfaces in a corner are longer than the walls by half a thickness each, and a rib that reaches "
    "the mid-surfaces is longer too: `extend` is soft by 2 %. With arms what remains is the mesh.",
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
