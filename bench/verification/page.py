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
    "(+2.3 % of the area of the I): too stiff; with `--tee arms` the web stops at the flange. CalculiX takes BOX and "
    "PIPE for B32R only (B31, B31R and B32 are refused), which are bricks inside and shear over their whole area, "
    "not over the webs. For this box that alone would be -1.13 %; with elements of 50, 25, 12.5 and 5 mm ccx gives "
    "-1.55, -1.35, -1.27 and -1.24 %. At 2.5 m it is -0.18 %, and ccx -0.13 %.",
    "tees": "Extended webs count half of each flange twice, which stiffens the long beam by 2.5 % (its second moment "
    "of area by 2.8 %); by arms it is within 0.3 %. The short beam is as much sheared as bent: with the web's whole "
    "height as its shear area, 120 x 8 instead of the section's own, the reference is 5 % stiffer, and the five "
    "differences at 360 read +4.0, +4.0, +5.2, +4.8 and +3.8 %. This case alone: `PYTHONPATH=bench python -m "
    "verification tees`.",
    "pipes": "CalculiX's PIPE does not converge: elements of 50, 25, 12.5, 8 and 5 mm give -5.35, -4.60, -3.72, "
    "-2.86 and -1.42 %, where shear over the whole area alone would be -4.74 %. What makes it softer as elements get "
    "shorter than the wall is wide is not known to us. At 1.5 m the same sizes give -1.04 to -0.71 %, and the area "
    "-0.57 %.",
    "halves": "What is left is not the coupling's. The same bar all of bricks, of the same sizes, is -1.64 % at 10 "
    "mm and -1.06 % at 6 mm in MYSTRAN, -0.85 and -0.70 % in CalculiX: hexes in bending, and a clamped root that "
    "cannot contract.",
    "halves_in_six": "The torque is mostly the bricks' as well: with those at 4 mm it is -0.55 % distributing, -1.27 "
    "% rigid and -0.89 % by work (at 10 mm -2.61, -3.19, -2.82 %). A rigid face does not warp and stays some 1 % "
    "stiff.",
    "joint_stress": "Work is shared out as beam theory has the stresses; 20 mm into the solid all three agree with M "
    "/ W. The limits here are what each coupling is known to do, not what is asked of it.",
    "stiffener": "A bar as a line has no width: the plate's fields reach from the rim to the bar's middle, 200 mm, "
    "where the solid bar leaves them 196 mm. The mixed models at 10 mm are soft by 1.3, 3.5 and 8.8 % for bars 4, 8 "
    "and 16 mm wide (plate and beam, MYSTRAN), so that it is the width, and no finer mesh helps. In CalculiX a beam "
    "is tied to a plate by knots, each of which holds its section from contracting: the strip is -4.4, -5.5 and -7.9 "
    "% at 20, 10 and 5 mm, and 0.0 % at all three with Poisson's ratio 0. There a stiffener is better as a plate.",
    "fin": "The root of a thick plate turns within the block. The plate clamped by itself is -5.5 %; O'Donnell (J. "
    "Appl. Mech. 27, 1960) has the root as 0.44 of the thickness in length, 6.6 %. Bricks twice as large as the "
    "plate is thick show next to nothing of it, whatever the coupling; at 3.5 mm most of it is there, but then the "
    "freedoms are fewer by three times only.",
    "boss": "The plate's normals stay straight up to the boss's rim, where in the solid they turn within the boss, "
    "as at the root of the plate on a block. It comes in only slowly as elements get finer (-7.0, -4.6, -3.6 % at "
    "12, 6, 4 mm against solids of 6 and 4 mm), and with a plate half as thick it is half as much (-4.0, -2.8, -2.0 "
    "%).",
    "table": "That 50 mm are within 2 % is in part luck: the mesh is stiff there and the foot soft, and refined the "
    "mixed model moves away from the solid. The mean of the contact (distributing, work) leaves the top as soft over "
    "a leg as elsewhere; a rigid contact lets nothing give (-8.1, -7.1, -6.3 % at 50, 25, 12.5 mm in MYSTRAN). The "
    "truth lies between: the leg stiffens the top, but is elastic itself. The reference hangs on the order of "
    "convergence: MYSTRAN at 50 mm is +2.2 % against the finest solid as it stands, +1.95 % with the order that "
    "three sizes (20, 10, 7 mm) show, +1.70 % with that of a right-angled inner edge, which the table uses.",
    "bracket": "Mid-surfaces in a corner are longer than the walls by half a thickness each, and a rib that reaches "
    "the mid-surfaces is longer too: `extend` is soft by 2 % (1.5 mm: +2.3 %). By arms it is -3.5, -0.3 and +0.5 % "
    "at 6, 3 and 1.5 mm in MYSTRAN: 6 mm are coarse for walls of 3 mm that bend, and CalculiX's four-node "
    "shells, on the skewed elements at the rib's slanted edge, are stiffer still. A third solid (8 mm: 9.753) "
    "suggests a faster order of convergence and 10.19 as the limit; "
    "against that all plates are 0.8 % softer than shown.",
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
