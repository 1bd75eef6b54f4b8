"""The table as beams and plate against the same table as bricks: degrees of freedom, as a Markdown table.

    python bench/table_dof.py [SIZE]

The bricks get the same target size as the frame; with `SIZE` of half the top's thickness they get the two layers that
bending wants.
"""

from __future__ import annotations

import sys
from pathlib import Path

from app.pipeline import Meshed, classify, mesh, read
from kernel.connect.model import Model, Mpc
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

TABLE = Path(__file__).resolve().parent.parent / "examples" / "table.csg"


def degrees_of_freedom(model: Model) -> int:
    """Six at each node of a beam or shell, three at the others, less those that couplings make dependent."""
    with_rotations: set[int] = set()
    others: set[int] = set()
    for block in model.mesh.blocks:
        nodes = set(block.connectivity.ravel().tolist())
        (others if ELEMENT_KINDS[block.kind].dimension == 3 else with_rotations).update(nodes)
    dependent = 0
    for coupling in model.couplings:
        if isinstance(coupling, Mpc):
            dependent += 1
        else:
            count = 1 if isinstance(coupling.dependent, int) else len(coupling.dependent)
            dependent += count * len(coupling.components)
    return 6 * len(with_rotations) + 3 * len(others - with_rotations) - dependent


def row(title: str, meshed: Meshed) -> str:
    elements = ", ".join(f"{count} {kind}" for kind, count in meshed.assembly.mesh.count().items())
    return (
        f"| {title} | {meshed.assembly.mesh.n_node:,} | {elements} | {len(meshed.model.couplings):,} "
        f"| {meshed.checks.components} | {degrees_of_freedom(meshed.model):,} |"
    )


def main() -> None:
    size = float(sys.argv[1]) if len(sys.argv) > 1 else 12.5
    csg = read(str(TABLE))
    frame = mesh(classify(csg))
    nodes = {segment.node for segment in frame.classified.partition.segments}
    bricks = classify(csg, overrides={node: Override("brick") for node in nodes})
    print("| model | nodes | elements | couplings | components | degrees of freedom |")
    print("|---|---|---|---|---|---|")
    print(row("1 plate + 4 beams, automatic size", frame))
    print(row("5 bricks, automatic size", mesh(bricks)))
    print(row(f"5 bricks, size {size:g}", mesh(bricks, MeshOptions(size=size))))


if __name__ == "__main__":
    main()
