"""Assigning a type to a piece: can it be that type, and what draft comes of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kernel.errors import OverrideError
from kernel.segment.prism import Prism, measure
from kernel.segment.shapes import Draft, wall_type
from kernel.segment.walls import PlaneWall, TubeWall, enclosing_tube
from kernel.units import ANGLE_TOLERANCE

if TYPE_CHECKING:
    from kernel.plan import Decision
    from kernel.segment.pieces import Piece

NEARLY_VOLUME = 0.03
"""A solid whose volume differs by less from section x length is nearly prismatic (prototype's labelled sets) ..."""

NEARLY_SECTIONS = 3
"""... with at most this many of its nine sections off ..."""

NEARLY_WORST = 0.3
"""... and none by more than this share: a beam with bolt holes stays a beam of its gross section."""

WHOLE_WALL = 0.95
"""A wall that holds this share of a solid is the solid, crumbs aside."""


class UnfitError(Exception):
    """The piece cannot be the type that was concluded; `reason` says why."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason

    def as_override_error(self, path: str, type_: str) -> OverrideError:
        """The same, to the user whose override it was."""
        return OverrideError(f"override of {path} as {type_} cannot be: {self.reason}")


def is_nearly_prismatic(prism: Prism) -> bool:
    """Exactly a prism, or a prism but for holes and ends."""
    return prism.sweep.is_exact or (
        prism.volume_deviation <= NEARLY_VOLUME
        and prism.sections_off <= NEARLY_SECTIONS
        and prism.worst_section_off <= NEARLY_WORST
    )


def drafts_as_one(piece: Piece, decision: Decision) -> tuple[Draft, ...]:
    """The piece as one beam, plate, cylinder-plate or brick. UnfitError: it cannot be that."""
    match decision.type:
        case "beam":
            return (_as_beam(piece, decision),)
        case "plate":
            return (_as_plate(piece, decision),)
        case "cylinder_plate":
            return (_as_cylinder_plate(piece, decision),)
        case "brick":
            return (Draft(piece.path, piece.name, "brick", decision, piece.solid, piece.solid),)
    raise UnfitError(f"no segment is a {decision.type}")


def drafts_of_walls(piece: Piece, decision: Decision) -> tuple[Draft, ...]:
    """One draft for each wall. UnfitError: the piece has none."""
    if not piece.walls.parts:
        raise UnfitError(
            "no walls were found: no two opposite faces are near enough to one another for their width "
            "(4 thicknesses; for coaxial cylinders, mean radius 5 thicknesses)"
        )
    return tuple(
        Draft(piece.path, piece.name, wall_type(part.wall), decision, part.solid, part.solid, wall=part.wall)
        for part in piece.walls.parts
    )


def _as_beam(piece: Piece, decision: Decision) -> Draft:
    """An analyst may call a beam what the rules do not, as a short member cut askew: most sections have to agree."""
    prism = piece.prism
    if prism is None:
        raise UnfitError("it is not prismatic along any direction")
    by_word = decision.origin == "override" and prism.sections_off <= NEARLY_SECTIONS
    if not is_nearly_prismatic(prism) and not by_word:
        raise UnfitError(
            f"it is not prismatic along any direction: of its nine sections {prism.sections_off} differ from the "
            f"median one, by up to {prism.worst_section_off:.0%} of its area, expected no more than {NEARLY_SECTIONS}"
        )
    return Draft(piece.path, piece.name, "beam", decision, piece.solid, piece.solid, prism=prism)


def _as_plate(piece: Piece, decision: Decision) -> Draft:
    """An analyst may call one plate what the rules call several, as a plate with pockets: all have to be parallel."""
    wall = _only_plane_wall(piece)
    if wall is None and decision.origin == "override":
        wall = _largest_of_parallel_walls(piece)
    if wall is None:
        exact = [sweep for sweep in piece.sweeps if sweep.is_exact]
        if not exact:
            raise UnfitError("it is neither one wall nor a prism")
        prism = measure(piece.solid, min(exact, key=lambda sweep: sweep.length))
        assert prism is not None
        wall = _across(piece, prism)
    return Draft(piece.path, piece.name, "plate", decision, piece.solid, piece.solid, wall=wall)


def _only_plane_wall(piece: Piece) -> PlaneWall | None:
    parts = piece.walls.parts
    if len(parts) == 1 and piece.walls.share >= WHOLE_WALL and isinstance(parts[0].wall, PlaneWall):
        return parts[0].wall
    return None


def _largest_of_parallel_walls(piece: Piece) -> PlaneWall | None:
    """The wall that holds most, where the piece is nothing but walls parallel to one another."""
    parts = piece.walls.parts
    walls = [part.wall for part in parts if isinstance(part.wall, PlaneWall)]
    if not walls or len(walls) < len(parts) or piece.walls.share < WHOLE_WALL:
        return None
    if any(np.abs(np.cross(wall.normal, walls[0].normal)).max() > ANGLE_TOLERANCE for wall in walls):
        return None
    return walls[int(np.argmax([part.solid.volume for part in parts]))]


def _across(piece: Piece, prism: Prism) -> PlaneWall:
    """The plate across a prism's axis: its thickness is the prism's length, its holes those of the section."""
    table, direction = piece.solid.surfaces, prism.sweep.direction
    bottom, top = (table.find_plane(direction, at) for at in (prism.sweep.start, prism.sweep.end))
    return PlaneWall(
        surface_ids=(-1 if bottom is None else bottom, -1 if top is None else top),
        normal=direction,
        u=prism.u,
        v=prism.v,
        bottom=prism.sweep.start,
        top=prism.sweep.end,
        paired=prism.section,
    )


def _as_cylinder_plate(piece: Piece, decision: Decision) -> Draft:
    parts = piece.walls.parts
    wall: TubeWall | None = None
    if len(parts) == 1 and piece.walls.share >= WHOLE_WALL and isinstance(parts[0].wall, TubeWall):
        wall = parts[0].wall
    wall = wall or enclosing_tube(piece.solid)
    if wall is None:
        raise UnfitError("no pair of coaxial cylinders encloses it")
    return Draft(piece.path, piece.name, "cylinder_plate", decision, piece.solid, piece.solid, wall=wall)
