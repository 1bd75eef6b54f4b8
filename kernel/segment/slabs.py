"""Thin-wall decomposition: the solid between each wall's faces, and who gets the corners where walls meet.

    slab of a wall = the solid between its faces, over the paired region (holes filled), grown into crossing walls
    a corner, where two slabs overlap, goes to one of the two walls (corners.py)

The remainder is what no slab holds; crumbs of it go to the wall they share most area with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import Polygon

from kernel.segment.corners import EMPTY, WallPart, settle_corners
from kernel.segment.faces import Region, faces_of
from kernel.segment.slices import parts_of, slice_loops, slice_polygon
from kernel.segment.traces import footprint_of, is_parallel, is_tangent, strips_beside, trace_of
from kernel.segment.walls import LARGE_HOLE, PlaneWall, TubeWall, Wall, find_walls, least_radius
from kernel.solid.fins import without_fins
from kernel.solid.solid import half_space_cut, intersect, prism, subtract, tube, unite
from kernel.solid.surfaces import CylinderSurface, PlaneFrame
from kernel.units import VOLUME_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

GROWTH = 1.1
"""Into a crossing wall a slab grows by this many times what it takes to reach through it, along itself."""

COVER = 0.98
"""Share of a paired region that must be solid half-way between the faces."""

LEDGE = 0.02
"""A slab that holds more than its mid-section times its thickness by this share has thinner parts beside that section:
one of two plates side by side that goes on beyond the other."""

SKIN_DEPTH = 0.01
"""How far within its faces, as a share of its thickness, a wall's material is looked for."""

CRUMB_SHARE = 2e-3
"""A piece of the remainder smaller than this share of the whole is a crumb (fillets, corner dust)."""

CRUMB_SIZE = 30.0
"""So is a piece smaller than this many cubes of the thickest wall's thickness, while under CRUMB_LIMIT."""

CRUMB_LIMIT = 5e-3
"""No crumb is larger than this share of the whole."""

CRUMB_REACH = 5.0
"""Nor does it stand off its wall by more than this many thicknesses of the thickest: a fillet does not, a rod does."""


FLAKES = 0.5 * VOLUME_TOLERANCE
"""Flakes that hold a smaller share of the whole may be missed."""


@dataclass(frozen=True, slots=True, eq=False)
class WallDecomposition:
    """The walls of a solid, disjoint, and what is left. share: of the volume that the walls hold."""

    parts: tuple[WallPart, ...]
    remainder: tuple[Solid, ...]
    share: float


def decompose(solid: Solid) -> WallDecomposition:
    """The solid's walls and what they leave."""
    faces = faces_of(solid)
    walls = find_walls(faces)
    volume = solid.volume
    slabs: list[tuple[Wall, Solid]] = []
    for wall in walls:
        slab = _plane_slab(solid, wall, walls) if isinstance(wall, PlaneWall) else _tube_slab(solid, wall, walls)
        if slab is not None and slab.volume > EMPTY * volume:
            slabs.append((wall, slab))
    if not slabs:
        return WallDecomposition((), solid.components(), 0.0)
    parts = [_as_trimmed(part) for part in settle_corners(solid, slabs)]
    remainder = _less(solid, parts)
    parts, remainder = _give_crumbs(parts, remainder, volume)
    parts = _with_flakes(solid, parts, remainder)
    held = sum(part.solid.volume for part in parts)
    return WallDecomposition(tuple(parts), tuple(remainder), min(held / volume, 1.0))


def _less(solid: Solid, parts: list[WallPart]) -> list[Solid]:
    """Components of the solid without the parts, rounding left out."""
    if not parts:
        return list(solid.components())
    if len(parts) == 1 and parts[0].solid is solid:
        return []
    if solid.volume - sum(part.solid.volume for part in parts) < EMPTY * solid.volume:
        return []  # parts are disjoint; a Boolean of nothing but coincident faces has come out with a piece of them
    rest = _without(solid, [part.solid for part in parts])
    if rest.is_empty or rest.volume < EMPTY * solid.volume:
        return []
    pieces = [piece for piece in rest.components() if piece.volume > EMPTY * solid.volume]
    if rest.volume - sum(piece.volume for piece in pieces) > EMPTY * solid.volume:
        # skins of no thickness all over the parts make a flake of what hangs on them: they go first
        pieces = list(without_fins(rest).components())
    return [without_fins(piece) for piece in pieces if piece.volume > EMPTY * solid.volume]


def _without(solid: Solid, parts: list[Solid]) -> Solid:
    """The solid less its disjoint parts.

    A Boolean of many bodies that share faces may leave some of it behind; then they are taken one after the other.
    """
    expected = solid.volume - sum(part.volume for part in parts)
    rest = subtract(solid, parts)
    if abs(rest.volume - expected) <= FLAKES * solid.volume:
        return rest
    again = solid
    for part in parts:
        again = subtract(again, [part])
    return min((rest, again), key=lambda other: abs(other.volume - expected))


# ---------------------------------------------------------------- slabs


def _plane_slab(solid: Solid, wall: PlaneWall, walls: tuple[Wall, ...]) -> Solid | None:
    """The solid between the wall's faces, limited to its own region and to the crossing walls it reaches into."""
    tolerance = solid.surfaces.tolerance
    slab = solid
    along = solid.facets.vertices @ wall.normal
    if along.min() < wall.bottom - tolerance:
        slab = half_space_cut(slab, wall.normal, wall.bottom)
    if along.max() > wall.top + tolerance:
        slab = half_space_cut(slab, -wall.normal, -wall.top)
    half_way = 0.5 * (wall.bottom + wall.top)
    if slab is solid:
        area = float(slice_loops(solid.facets, wall.normal, half_way, wall.u, wall.v).sum())
        if wall.paired.area >= COVER * area:
            return solid
    middle = slice_polygon(slab.facets, wall.normal, half_way, wall.u, wall.v)
    if wall.paired.intersection(middle).area < COVER * wall.area:
        return None
    own = _grown(_filled(solid, wall, walls, middle), wall, walls)
    loose = own.buffer(10.0 * tolerance)
    inside = shapely.union_all([part for part in parts_of(loose.intersection(middle)) if part.intersects(wall.paired)])
    if slab.volume <= (1.0 + LEDGE) * middle.area * wall.thickness:
        if inside.area >= middle.area * (1.0 - 1e-9):
            return slab
        if parts_apart(middle, loose):
            return _touching(slab, wall)
    frame = PlaneFrame(wall.u, wall.v, wall.normal)
    reach = wall.thickness
    outline = shapely.union_all([Polygon(part.exterior) for part in parts_of(own)])
    outline = _on_vertices(outline, slab, wall, 10.0 * tolerance)
    cutter = prism(solid.surfaces, outline, frame, wall.bottom - reach, wall.top + reach)
    return _touching(intersect([slab, cutter]), wall)


def parts_apart(middle: Region, own: Region) -> bool:
    """Whether every connected part of the mid-section lies either wholly inside `own` or wholly outside it."""
    for part in parts_of(middle):
        inside = part.intersection(own).area
        if 1e-9 * part.area < inside < (1.0 - 1e-9) * part.area:
            return False
    return True


def _touching(slab: Solid, wall: PlaneWall) -> Solid | None:
    """The components of a slab that lie over the paired region."""
    if slab.is_empty:
        return None
    components = slab.components()
    kept = []
    for component in components:
        middle = slice_polygon(component.facets, wall.normal, 0.5 * (wall.bottom + wall.top), wall.u, wall.v)
        if middle.intersection(wall.paired).area > 1e-6 * middle.area > 0.0:
            kept.append(component)
    if not kept:
        return None
    return slab if len(kept) == len(components) else unite(kept)


def _grown(filled: Region, wall: PlaneWall, walls: tuple[Wall, ...]) -> Region:
    """The region, grown inside the slabs of walls that cross it, into each as far as it takes to leave that one.

    No further: beyond a plate that a web stands on, another web may stand in line with it (a beam over its column).
    """
    crossing = [other for other in walls if other is not wall and not is_parallel(wall, other)]
    crossing = [other for other in crossing if not (isinstance(other, TubeWall) and is_tangent(wall, other))]
    if not crossing:
        return filled
    ways = [_way_through(wall, other) for other in crossing]
    left, low, right, high = filled.buffer(GROWTH * max(ways), join_style="mitre").bounds
    reach = (right - left) + (high - low)
    centre = np.array([0.5 * (left + right), 0.5 * (low + high)])
    strips: dict[float, list[Region]] = {}
    for other, way in zip(crossing, ways, strict=True):
        if (strip := trace_of(wall, other, centre, reach)) is not None:
            strips.setdefault(round(way, 12), []).append(strip)
    grown = [
        filled.buffer(GROWTH * way, join_style="mitre").intersection(shapely.union_all(crossed))
        for way, crossed in sorted(strips.items())
    ]
    return shapely.union_all([filled, *grown])


def _way_through(wall: PlaneWall, other: Wall) -> float:
    """How far along the wall it goes from where one of its faces enters the other wall to where both have left it."""
    if isinstance(other, TubeWall):
        return other.thickness
    cosine = abs(float(wall.normal @ other.normal))
    return (other.thickness + wall.thickness * cosine) / float(np.sqrt(1.0 - cosine * cosine))


def _filled(solid: Solid, wall: PlaneWall, walls: tuple[Wall, ...], middle: Region) -> Region:
    """The paired region with its holes, and with what stands on its edge as it might inside.

    Where only one of the two faces is there, the edge is bevelled, or something stands on the other: then the material
    goes from face to face. It is filled in at the edge too, where it is no larger than a LARGE_HOLE and no other
    wall's, or where a tube lies along the wall.
    """
    filled = shapely.union_all([Polygon(part.exterior) for part in parts_of(wall.paired)])
    faces = faces_of(solid)
    bottom, top = wall.surface_ids
    one_sided = faces.polygon(bottom, -1).union(faces.polygon(top, 1)).intersection(middle).difference(filled)
    others = [footprint_of(wall, other) for other in walls if other is not wall and isinstance(other, PlaneWall)]
    if others:
        one_sided = one_sided.difference(shapely.union_all(others))
    size = max(1e-6 * wall.area, solid.surfaces.tolerance * wall.thickness)
    edges = [part for part in parts_of(one_sided) if size < part.area <= LARGE_HOLE * wall.thickness**2]
    wide = [part for part in edges if not part.buffer(-0.5 * wall.thickness).is_empty]
    if wide:
        through = shapely.union_all(wide).intersection(_through(solid, wall))
        edges = [part for part in edges if part not in wide] + [part for part in parts_of(through) if part.area > size]
    tubes = [strips_beside(wall, other) for other in walls if isinstance(other, TubeWall)]
    if any(not strip.is_empty for strip in tubes):
        edges += [part for part in parts_of(one_sided.intersection(shapely.union_all(tubes))) if part.area > size]
    edges = [part for part in edges if part.distance(filled) < solid.surfaces.tolerance]
    return shapely.union_all([filled, *edges]) if edges else filled


def _through(solid: Solid, wall: PlaneWall) -> Region:
    """Where the solid goes from one of the wall's faces to the other, by its sections just inside of both."""
    depth = SKIN_DEPTH * wall.thickness
    low, high = (
        slice_polygon(solid.facets, wall.normal, offset, wall.u, wall.v)
        for offset in (wall.bottom + depth, wall.top - depth)
    )
    return low.intersection(high)


def _on_vertices(outline: Region, slab: Solid, wall: PlaneWall, near: float) -> Region:
    """The outline with its corners moved onto the slab's vertices where they are near: cuts then fit faces exactly."""
    known = slab.facets.vertices @ np.stack([wall.u, wall.v], axis=1)

    def onto(points: np.ndarray) -> np.ndarray:
        distance = np.abs(points[:, None, :] - known[None, :, :]).max(axis=2)
        nearest = distance.argmin(axis=1)
        close = distance[np.arange(len(points)), nearest] < near
        return np.where(close[:, None], known[nearest], points)

    return shapely.remove_repeated_points(shapely.transform(outline, onto), near)


def _tube_slab(solid: Solid, wall: TubeWall, walls: tuple[Wall, ...]) -> Solid | None:
    """The solid between the wall's cylinders, over its own stretch of the axis and the walls that cross its ends."""
    arm = solid.facets.vertices - wall.axis.point
    along = arm @ wall.axis.direction
    radius = np.hypot(arm @ wall.axis.x, arm @ wall.axis.y)
    crossing = [other.thickness for other in walls if other is not wall]
    growth = GROWTH * max(crossing, default=0.0)
    _, low, _, high = wall.paired.bounds
    low, high = max(float(along.min()), low - growth), min(float(along.max()), high + growth)
    tolerance = 10.0 * solid.surfaces.tolerance
    fills = (
        least_radius(solid, wall.axis) > wall.inner_radius - tolerance
        and radius.max() < wall.outer_radius + tolerance
        and along.min() > low - tolerance
        and along.max() < high + tolerance
    )
    if fills:
        return solid
    cutter = tube(solid.surfaces, wall.axis_id, wall.inner_radius, wall.outer_radius, low, high)
    slab = intersect([solid, cutter])
    if slab.is_empty:
        return None
    kept = [piece for piece in slab.components() if _holds_face(piece, wall)]
    if not kept:
        return None
    return slab if len(kept) == len(slab.components()) else unite(kept)


def _holds_face(piece: Solid, wall: TubeWall) -> bool:
    """Whether the piece has some of both of the wall's faces, from the solid itself and not from the cutter."""
    facets = piece.facets
    own = facets.source >= 0
    return all(bool((own & (facets.surface == surface)).any()) for surface in wall.surface_ids)


def _as_trimmed(part: WallPart) -> WallPart:
    """The part, its wall between the faces that it kept: on what it lay, another wall may have won all beneath it."""
    wall, table = part.wall, part.solid.surfaces
    if isinstance(wall, PlaneWall):
        along = part.solid.facets.vertices @ wall.normal
        bottom, top = max(float(along.min()), wall.bottom), min(float(along.max()), wall.top)
        low, high = wall.surface_ids
        if bottom > wall.bottom + table.tolerance:
            low = _found(table.find_plane(wall.normal, bottom), low)
        if top < wall.top - table.tolerance:
            high = _found(table.find_plane(wall.normal, top), high)
        if (low, high) == wall.surface_ids:
            return part
        return replace(part, wall=replace(wall, surface_ids=(low, high), bottom=bottom, top=top))
    held = faces_of(part.solid).areas
    coaxial = [
        (surface.radius, number, side)
        for number, side in sorted(held)
        if isinstance(surface := table.surfaces[number], CylinderSurface) and surface.axis_id == wall.axis_id
    ]
    inner, low = max(((r, n) for r, n, side in coaxial if side < 0), default=(wall.inner_radius, wall.surface_ids[0]))
    outer, high = min(((r, n) for r, n, side in coaxial if side > 0), default=(wall.outer_radius, wall.surface_ids[1]))
    if not wall.inner_radius <= inner < outer <= wall.outer_radius or (low, high) == wall.surface_ids:
        return part
    if wall.surface_ids[0] in {n for _, n, _ in coaxial} and wall.surface_ids[1] in {n for _, n, _ in coaxial}:
        return part  # both faces are there, and something ends against the wall between them
    return replace(part, wall=replace(wall, surface_ids=(low, high), inner_radius=inner, outer_radius=outer))


def _found(number: int | None, otherwise: int) -> int:
    return otherwise if number is None else number


# ---------------------------------------------------------------- crumbs


def _give_crumbs(parts: list[WallPart], remainder: list[Solid], volume: float) -> tuple[list[WallPart], list[Solid]]:
    """Crumbs of the remainder handed to the parts they share most area with; what is no crumb stays."""
    if not remainder or not parts:
        return parts, remainder
    thickest = max(part.wall.thickness for part in parts)
    kept: list[Solid] = []
    for piece in sorted(remainder, key=lambda piece: -piece.volume):
        share = piece.volume / volume
        if share > CRUMB_LIMIT or (share > CRUMB_SHARE and piece.volume > CRUMB_SIZE * thickest**3):
            kept.append(piece)
            continue
        host = most_shared([part.solid for part in parts], piece)
        if host is None or _stands_off(parts[host].wall, piece) > CRUMB_REACH * thickest:
            kept.append(piece)
        else:
            parts[host] = replace(parts[host], solid=unite([parts[host].solid, piece]))
    return parts, kept


def _stands_off(wall: Wall, piece: Solid) -> float:
    """How far the piece reaches from the wall's nearer face."""
    points = piece.facets.vertices
    if isinstance(wall, PlaneWall):
        offsets = points @ wall.normal
        return max(float(offsets.max()) - wall.top, wall.bottom - float(offsets.min()))
    arms = points - wall.axis.point
    radii = np.linalg.norm(np.cross(arms, wall.axis.direction), axis=1)
    return max(float(radii.max()) - wall.outer_radius, wall.inner_radius - float(radii.min()))


def _with_flakes(solid: Solid, parts: list[WallPart], remainder: list[Solid]) -> list[WallPart]:
    """The parts, with what lies between them and is thinner than the tolerance: two plates a hair apart, both in one
    slab. No segment is to be made of it, but where there is much of it its volume is missed.

    Flat parts only: along a curved one flakes are the chords' rounding, which the whole wall takes with it.
    """
    flat = [index for index, part in enumerate(parts) if isinstance(part.wall, PlaneWall)]
    missed = solid.volume - sum(part.solid.volume for part in parts) - sum(piece.volume for piece in remainder)
    if not flat or missed < FLAKES * solid.volume:
        return parts
    for flake in _without(solid, [*(part.solid for part in parts), *remainder]).flakes():
        found = most_shared([parts[index].solid for index in flat], flake)
        if found is not None:
            host = flat[found]
            parts[host] = replace(parts[host], solid=unite([parts[host].solid, flake]))
    return parts


def most_shared(solids: list[Solid], piece: Solid) -> int | None:
    """Index of the solid that shares most surface with `piece`; None where none touches it."""
    best, most = None, 0.0
    slack = 1e-6 * piece.size + piece.surfaces.tolerance
    for index, solid in enumerate(solids):
        if np.any(solid.bounds[0] > piece.bounds[1] + slack) or np.any(piece.bounds[0] > solid.bounds[1] + slack):
            continue
        shared = solid.area + piece.area - unite([solid, piece]).area
        if shared > max(most, 1e-9 * piece.area):
            best, most = index, shared
    return best
