"""Describing: the facts of one piece of the model, tier by tier, in the vocabulary of facts.py.

Geometry gives facts and never judges. Numbers are rounded to FACT_DIGITS significant digits, so that equal pieces
give equal facts however they are turned, moved or written, and a limit met exactly is met.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely

from kernel.facts import Facts, Value
from kernel.segment.fits import diameter_of, fit
from kernel.segment.holes import round_holes
from kernel.segment.operands import leaf_count, operand_at, operand_count, operands_of, tools_of
from kernel.segment.slices import outline_points, parts_of, slice_polygon, smallest_rectangle
from kernel.segment.supports import contacts_along, free_length
from kernel.solid.surfaces import plane_frame

if TYPE_CHECKING:
    from kernel.csg.tree import CsgNode
    from kernel.segment.pieces import Piece
    from kernel.segment.prism import Prism
    from kernel.segment.walls import PlaneWall
    from kernel.solid.solid import Solid

FACT_DIGITS = 6
"""Significant digits of a measured fact: what six-digit input can tell apart."""


def intent(piece: Piece) -> Facts:
    """What the tree says, before anything is measured: of the piece, of its tools and of its children."""
    if piece.intent is None:
        piece.intent = _intent(piece)
    return piece.intent


def _intent(piece: Piece) -> Facts:
    operand = piece.operand
    if operand is None:
        return Facts(
            _of_tree("piece", piece.role, False, piece.depth, 1, 0, 0), "intent", {"tools": (), "children": ()}
        )
    children = operands_of(operand)
    tools = tuple(tools_of(operand))
    values = _of_tree(
        operand.node.kind,
        piece.role,
        operand.node.name is not None,
        piece.depth,
        operand_count(operand.node),
        len(tools),
        leaf_count(operand),
    ) | _diameter(operand.node)
    related = {
        "tools": tuple(_of_node(tool, piece.depth + 1, fit(tool, operand.node)) for tool in tools),
        "children": tuple(_of_node(child.node, piece.depth + 1, {}) for child in children),
    }
    return Facts(values, "intent", related)


def _of_node(node: CsgNode, depth: int, more: Mapping[str, Value]) -> Facts:
    """Facts of a tool or a child, from the tree alone; more: what is known of it besides."""
    operand = operand_at("/", node)
    tools = sum(1 for _ in tools_of(operand))
    leaves = leaf_count(operand)
    values = _of_tree(node.kind, "operand", node.name is not None, depth, operand_count(node), tools, leaves)
    return Facts({**values, **_diameter(node), **more}, "intent")


def _diameter(node: CsgNode) -> dict[str, Value]:
    diameter = diameter_of(node)
    return {} if diameter is None else {"diameter": round_fact(diameter)}


def _of_tree(
    kind: str, role: str, is_named: bool, depth: int, operands: int, tools: int, leaves: int
) -> dict[str, Value]:
    return {
        "kind": kind,
        "role": role,
        "is_named": is_named,
        "depth": depth,
        "operand_count": operands,
        "tool_count": tools,
        "leaf_count": leaves,
    }


def extents(piece: Piece) -> dict[str, Value]:
    """Cheap measures of the solid."""
    solid = piece.solid
    long, middle, short = own_box(piece)
    return _rounded(
        {
            **_holes(solid),
            "volume": solid.true_volume,
            "component_count": len(piece.components),
            "extent_long": long,
            "extent_middle": middle,
            "extent_short": short,
            "fill": min(solid.volume / (long * middle * short), 1.0),
        }
    )


def _holes(solid: Solid) -> dict[str, Value]:
    holes = round_holes(solid)
    values: dict[str, Value] = {
        "round_hole_count": len(holes),
        "through_hole_count": sum(hole.is_through for hole in holes),
    }
    if holes:
        values |= {"smallest_hole": holes[0].diameter, "largest_hole": holes[-1].diameter}
    return values


def own_box(piece: Piece) -> tuple[float, float, float]:
    """Sides of the smallest box that stands square to one of the solid's own directions, longest first."""
    vertices = outline_points(piece.solid)
    best: tuple[float, float, float] | None = None
    for sweep in piece.sweeps:
        u, v, _ = plane_frame(sweep.direction)
        across = smallest_rectangle(shapely.multipoints(vertices @ np.stack([u, v], axis=1)))
        box = (sweep.length, *across)
        if best is None or math.prod(box) < math.prod(best) * (1.0 - 1e-9):
            best = box
    assert best is not None
    long, middle, short = sorted(best, reverse=True)
    return long, middle, short


def prism(piece: Piece) -> dict[str, Value]:
    """How the solid is swept along its best axis."""
    measured = piece.prism
    if measured is None:
        return {"is_prismatic": False}
    return _rounded(
        {
            "is_prismatic": measured.sweep.is_exact,
            "prism_length": measured.sweep.length,
            **_contacts(piece, measured),
            "section_long": measured.long_side,
            "section_short": measured.short_side,
            "section_area": measured.area,
            "slenderness": measured.slenderness,
            "flatness": measured.long_side / measured.short_side,
            "volume_deviation": measured.volume_deviation,
            "sections_off": measured.sections_off,
            "worst_section_off": measured.worst_section_off,
        }
    )


def related(piece: Piece, tier: str) -> dict[str, tuple[Facts, ...]]:
    """Facts of the things around the piece that a tier brings: its neighbours with the prism tier."""
    if tier != "prism":
        return {}
    return {"neighbours": tuple(intent(other) for other in piece.neighbours)}


def walls(piece: Piece) -> dict[str, Value]:
    """What the thin-wall decomposition found."""
    from kernel.segment.shapes import wall_holes
    from kernel.segment.walls import PlaneWall, TubeWall

    found = piece.walls
    parts = found.parts
    tubes = [part for part in parts if isinstance(part.wall, TubeWall)]
    values: dict[str, Value] = {
        "wall_count": len(parts),
        "plane_wall_count": len(parts) - len(tubes),
        "cylinder_wall_count": len(tubes),
        "wall_share": found.share,
        "hole_count": sum(wall_holes(part.wall, part.solid) for part in parts),
    }
    if parts:
        values["wall_thickness"] = max(part.wall.thickness for part in parts)
        values["thinnest_wall"] = min(part.wall.thickness for part in parts)
        values["wall_slenderness"] = min(part.wall.width / part.wall.thickness for part in parts)
    measured = [_strips(part.wall, part.solid) for part in parts if isinstance(part.wall, PlaneWall)]
    strips = [strip for strip in measured if strip is not None]
    if strips:
        values["outline_fill"], values["strip_ratio"] = min(strips)
    if tubes:
        values["radius_ratio"] = min(
            part.wall.mid_radius / part.wall.thickness for part in tubes if isinstance(part.wall, TubeWall)
        )
    return _rounded(values)


def _strips(wall: PlaneWall, solid: Solid) -> tuple[float, float] | None:
    """Of a flat wall's section half-way: the share of its outer outline that it fills, and the mean width of what it
    consists of, in thicknesses. A strip much longer than wide has twice its area / its perimeter as its width.

    Both rounded as facts are, so that of walls that are equally empty it is the one with the narrowest strips that
    tells, whatever rounding did. None of a wall that owns nothing half-way between its faces.
    """
    middle = slice_polygon(solid.facets, wall.normal, 0.5 * (wall.bottom + wall.top), wall.u, wall.v)
    if middle.is_empty:
        return None
    outline = sum(shapely.Polygon(part.exterior).area for part in parts_of(middle))
    width = 2.0 * middle.area / (middle.length * wall.thickness)
    return round_fact(min(middle.area / outline, 1.0)), round_fact(width)


def members(beams: Sequence[tuple[float, Prism]], cut_count: int, solid: Solid) -> dict[str, Value]:
    """What operands that are beams by themselves, (volume, prism) each, hold of the solid and fill of their boxes.

    cut_count: how many of them the other operands cut in pieces.
    """
    held = sum(volume for volume, _ in beams)
    values: dict[str, Value] = {"beam_share": held / solid.volume, "cut_beam_count": cut_count}
    if beams:
        filled = sum(volume * prism.area / (prism.long_side * prism.short_side) for volume, prism in beams)
        values["beam_fill"] = filled / held
    return _rounded(values)


def necks(piece_count: int, member_volume: float, volume: float) -> dict[str, Value]:
    """What cuts at necks would give: pieces, and the share of the volume that then is not brick."""
    return _rounded({"neck_count": piece_count, "neck_share": member_volume / volume})


MEASURES: Mapping[str, Callable[[Piece], dict[str, Value]]] = {"extents": extents, "prism": prism, "walls": walls}
"""How each tier is measured; necks ask about their pieces, so the walk measures them (segment/partition.py)."""


def measure(piece: Piece, tier: str) -> dict[str, Value]:
    """The facts of one tier; a piece that is a copy of another is measured only in what its neighbours change."""
    like = piece if piece.likeness is None else piece.likeness.of
    if tier not in like.measured:
        like.measured[tier] = MEASURES[tier](like)
    values = like.measured[tier]
    if like is piece or tier != "prism" or piece.prism is None:
        return values
    return {**values, **_rounded(_contacts(piece, piece.prism))}


def _contacts(piece: Piece, measured: Prism) -> dict[str, Value]:
    contacts = contacts_along(piece.solid, measured, tuple(other.solid for other in piece.neighbours))
    return {"free_length": free_length(piece.solid, measured, contacts), "contact_count": len(contacts)}


def _rounded(values: Mapping[str, Value]) -> dict[str, Value]:
    return {name: round_fact(value) if isinstance(value, float) else value for name, value in values.items()}


def round_fact(value: float) -> float:
    """`value` to FACT_DIGITS significant digits; shares within 1e-9 of 0 are 0."""
    if abs(value) < 1e-9 or not math.isfinite(value):
        return 0.0 if math.isfinite(value) else value
    return float(f"{value:.{FACT_DIGITS}g}")
