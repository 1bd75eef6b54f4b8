"""Models that decks are written of and read back from: each element kind, each coupling, examples, labelled cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

from handmade import cantilever, channel_outline, shell_cantilever, solid_cantilever, whole_set
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate

from app.pipeline import classify, mesh, read
from kernel.connect.model import Model
from kernel.mesh.options import MeshOptions

ROOT = Path(__file__).parents[2]

SHELLS = ("tri3", "tri6", "quad4", "quad8")
SOLIDS = ("tet4", "tet10", "wedge6", "wedge15", "hex8", "hex20")

MESHED: dict[str, tuple[str, dict]] = {
    "table": ("examples/table.csg", {"size": 100}),
    "table order 2": ("examples/table.csg", {"size": 100, "order": 2}),
    "bracket": ("examples/bracket.csg", {"size": 12}),
    "bracket order 2 of triangles": ("examples/bracket.csg", {"size": 12, "order": 2, "faces": "tri"}),
    "pipe with holes": ("examples/pipe_with_holes.csg", {"size": 20}),
    "i beam": ("examples/i_beam.csg", {}),
    "beam between plates": ("tests/cases/beam_between_plates.csg", {}),
    "block with fin": ("tests/cases/block_with_fin.csg", {"size": 25}),
    "block with fin order 2": ("tests/cases/block_with_fin.csg", {"size": 40, "order": 2}),
    "bars in a ring": ("tests/cases/four_bars_ring.csg", {}),
    "i between blocks": ("tests/cases/i_between_blocks.csg", {"size": 30}),
    "lap": ("tests/cases/lap_of_two_plates.csg", {}),
    "rail on sheet": ("tests/cases/rail_on_sheet.csg", {}),
    "stool": ("tests/cases/stool_round.csg", {}),
}  # fmt: skip
"""By name: the model and its mesh options."""


def _of_kind(kind: str) -> Model:
    if kind in SHELLS:
        model = shell_cantilever(kind, 8.0, 2.0, 1.0, (2, 1))
    elif kind in SOLIDS:
        model = solid_cantilever(kind, (8.0, 2.0, 2.0), (2, 1, 1))
    else:
        model = cantilever(channel_outline(), 100.0, 3, kind)
    return replace(model, sets=(whole_set(model, "PART"),))


HANDMADE: dict[str, Callable[[], Model]] = {
    **{kind: (lambda kind=kind: _of_kind(kind)) for kind in (*SHELLS, *SOLIDS, "line2", "line3")},
    **{
        f"half beam, half solid, {kind}": (lambda kind=kind: half_beam_half_solid(kind, divisions=(8, 2, 2)))
        for kind in ("distributing", "rigid", "work")
    },
    "post on plate": post_on_plate,
    "post on plate, rigid": lambda: post_on_plate("rigid"),
    "block on plate": block_on_plate,
    "lap of plates": lap_of_plates,
    "bracket of two materials, exact mass": lambda: _meshed(
        "examples/bracket.csg", MeshOptions(size=12), mass="exact", materials_of={"s1": "aluminium"}
    ),
    "table on titanium legs": lambda: _meshed(
        "examples/table.csg", MeshOptions(size=100), material="titanium", materials_of={"0": "concrete"}
    ),
}

NAMES = [*HANDMADE, *MESHED]


@cache
def model_named(name: str) -> Model:
    """One of NAMES, made once."""
    if name in HANDMADE:
        return HANDMADE[name]()
    path, options = MESHED[name]
    return _meshed(path, MeshOptions(**options))


def _meshed(path: str, options: MeshOptions, **more) -> Model:
    return mesh(classify(read(str(ROOT / path))), options, **more).model
