"""Tees by rigid arms: a web that stops at its flange's face, and hangs from the curve in which they would have met.

    extend          arms
      | web           | web          w  the edge in which the web now ends, on the flange's face
      |               w              j  the joint curve, imprinted in the flange
    --j-- flange    --j-- flange     w follows j rigidly: half the flange's thickness, along the web's mid-surface

The walls are first carried on to where their mid-surfaces meet, as ever. Where a wall then ends on a curve that lies
inside another's mid-surface, its part within that other's slab is cut off again. Corners (both walls end on the
curve) and crosses (neither does) keep their common curve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from kernel.connect.joints import Joint
from kernel.errors import ConnectError, OptionError
from kernel.idealise.askew import is_filled, own_edge
from kernel.idealise.crossings import Crossing, samples, slab_edges
from kernel.idealise.imprints import Candidate
from kernel.idealise.intersections import intersection
from kernel.idealise.outlines import PolygonLike, Stretch, unwrapped, windowed
from kernel.idealise.regions import GRID
from kernel.idealise.relined import drawn, outline_of
from kernel.idealise.strips import strip
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import Wall
from kernel.segment.slices import parts_of
from kernel.solid.surfaces import signed_distance

Array = NDArray[np.float64]

PROBES = np.array([0.07, 0.29, 0.5, 0.73, 0.91])
"""Where along a joint curve it is asked which walls go on beyond it; in no regular places, where others would meet."""

ASIDE = 0.05
"""How far beside the curve it is asked, as a share of the thinner wall."""

WITHIN = 0.5
"""A cell of the web goes when more than this share of it lies in the flange's slab along the joint curve."""

SAME_THICKNESS = 1e-6
"""Coplanar walls are one flange when their thicknesses differ by less than this share."""

NO_TEES = (
    "tee is arms, but no wall ends within another, so that there is nothing for an arm to reach: walls that both end "
    "on the curve in which they meet, as a pipe and its open branch do, count nothing twice there"
)

TeeOf = Callable[[Sequence[Joint]], str]
"""How tees on one curve are made, "extend" or "arms", by the joints that lie along it."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """A stretch `edge` of the web's outline that hangs from the stretch `along` of the joint curve.

    flanges: the walls, all on one sheet, inside which the joint curve lies. crossing: of the web and one of them.
    side: 1 where the web stands on the side to which the flange's normal points, else -1. gap: how far from the
    flange's face the web ends.
    """

    web: Wall
    flanges: tuple[Wall, ...]
    crossing: Crossing
    along: Stretch
    edge: Stretch
    side: float
    gap: float

    @property
    def joint(self) -> Joint:
        """The joint that it carries: the largest along the curve."""
        return max(self.crossing.joints, key=lambda joint: joint.area)

    @property
    def walls(self) -> tuple[Wall, ...]:
        """The web and its flanges."""
        return (self.web, *self.flanges)

    def edge_points(self, points: Array) -> Array:
        """The points (n, 3) of the web's edge that hang from points (n, 3) of the joint curve."""
        sides = slab_edges(self.web, self.flanges[0], points, self.gap)
        return sides[0] if self.side > 0 else sides[1]


@dataclass(frozen=True, slots=True, eq=False)
class _Tee:
    """A stretch of a joint curve on which the web is to be cut off, at the carrier `number`, `gap` off the face."""

    crossing: Crossing
    flanges: tuple[Wall, ...]
    along: Stretch
    side: float
    gap: float
    number: int


def extended(_joints: Sequence[Joint]) -> str:
    """All tees by mid-surfaces that are carried on."""
    return "extend"


def tee_choice(tee: str, of_joint: Mapping[str, str], joints: Sequence[Joint]) -> TeeOf:
    """What holds on a curve: what was said of a joint along it, else `tee`.

    of_joint: "extend" or "arms" by joint id. OptionError: an unknown joint; two along the curve that differ.
    """
    known = {joint.id for joint in joints}
    for name in of_joint:
        if name not in known:
            listed = ", ".join(joint.id for joint in joints) or "none"
            raise OptionError(f"no joint {name!r} in the model, expected one of {listed}")

    def of_curve(along: Sequence[Joint]) -> str:
        said = [joint for joint in along if joint.id in of_joint]
        for joint in said:
            if of_joint[joint.id] != of_joint[said[0].id]:
                raise OptionError(
                    f"tee of {said[0].id} is {of_joint[said[0].id]!r} and of {joint.id} {of_joint[joint.id]!r}, but "
                    f"both join {' and '.join(joint.segments)} along one curve: expected the same"
                )
        return of_joint[said[0].id] if said else tee

    return of_curve


def stand_off(
    topology: Topology,
    walls: Sequence[Wall],
    crossings: Sequence[Crossing],
    tee_of: TeeOf,
    warnings: list[str],
) -> list[Arm]:
    """Cut every web whose tee is to be made by arms back to its flange's face, and say what hangs from what.

    The walls must have been joined (regions.lay_regions). warnings: gets a line for each tee that stays extended,
    or one where arms were asked of all joint curves and none is a tee.
    """
    before = len(warnings)
    by_sheet: dict[int, list[Wall]] = {}
    for wall in walls:
        by_sheet.setdefault(wall.sheet.surface_id, []).append(wall)
    tees: dict[int, list[_Tee]] = {}
    for crossing in crossings:
        for web in crossing.walls:
            if tee_of(crossing.joints) == "arms":
                tees.setdefault(web.index, []).extend(_tees(topology, crossing, web, by_sheet, warnings))
    regions = {wall.index: _cut_region(topology, wall, tees[wall.index]) for wall in walls if tees.get(wall.index)}
    arms = []
    for wall in walls:
        if wall.index in regions:
            numbers = {tee.number for tee in tees[wall.index]}
            wall.known = sorted({*wall.known, *numbers})
            preferred = numbers | {crossing.carrier for crossing in crossings if wall in crossing.walls}
            wall.outline, wall.region = outline_of(topology, wall, regions[wall.index], preferred)
            arms += [arm for tee in tees[wall.index] for arm in _arms(topology, wall, tee)]
    if crossings and not arms and len(warnings) == before and all(tee_of(one.joints) == "arms" for one in crossings):
        warnings.append(NO_TEES)
    return arms


def unused_choices(of_joint: Mapping[str, str], joints: Sequence[Joint], arms: Sequence[Arm]) -> list[str]:
    """A line for each joint of which arms were asked, and that is no tee, or of which they were not asked, and that
    lies on the curve of one of which they were.
    """
    hung = {joint.id for arm in arms for joint in arm.crossing.joints}
    lines = []
    for joint in joints:
        if of_joint.get(joint.id) == "arms" and joint.id not in hung:
            names = f"{joint.kind} of {joint.segments[0]} and {joint.segments[1]}"
            lines.append(f"{joint.id} ({names}) has no arms: no wall ends within another there")
    for along in {id(arm.crossing): arm.crossing.joints for arm in arms}.values():
        said = [joint.id for joint in along if joint.id in of_joint]
        others = [joint.id for joint in along if joint.id not in of_joint]
        if said and others:
            lines.append(f"{' and '.join(others)}: by arms as {said[0]}, along one curve with it")
    return lines


def arm_candidates(arms: Sequence[Arm]) -> list[Candidate]:
    """The joint curves, in the flanges alone."""
    return [Candidate(flange, arm.along) for arm in arms for flange in arm.flanges]


# ---------------------------------------------------------------- which curves are tees


def _tees(
    topology: Topology, crossing: Crossing, web: Wall, by_sheet: dict[int, list[Wall]], warnings: list[str]
) -> list[_Tee]:
    """The stretches of the web's outline that lie within the mid-surface of the other wall."""
    other = crossing.other(web)
    level = [
        wall
        for wall in by_sheet[other.sheet.surface_id]
        if abs(wall.thickness - other.thickness) <= SAME_THICKNESS * other.thickness
    ]
    found = []
    for stretch in web.outline:
        if stretch.carrier != crossing.carrier:
            continue
        flanges = _walls_through(topology, stretch, level, web.thickness)
        if other not in flanges:
            continue
        if len(flanges) > 1 and _walls_through(topology, stretch, by_sheet[web.sheet.surface_id], np.inf):
            continue  # four walls in a cross
        tee = _as_tee(topology, crossing, web, flanges, stretch)
        if tee is None:
            amid = topology.carrier(stretch.carrier).at(np.array([0.5 * (stretch.start + stretch.end)]))[0]
            pipes = isinstance(topology.carrier(stretch.carrier), TubeCurve)
            why = "pipes of nearly one radius run side by side there, and the branch" if pipes else "it"
            warnings.append(
                f"{web.segment.id} is carried on into {other.segment.id} near {topology.place_text(amid)}: {why} "
                "has no edge at the face from which an arm could reach"
            )
        else:
            found.append(tee)
    return found


def _walls_through(topology: Topology, stretch: Stretch, walls: Sequence[Wall], thickness: float) -> tuple[Wall, ...]:
    """Those of some walls of one sheet that go on, together, on both sides of a curve in it; none where they end.

    thickness: of what stands on them, for how far beside the curve they are looked for.
    """
    sheet = walls[0].sheet
    carrier = topology.carrier(stretch.carrier)
    middles = stretch.start + PROBES * (stretch.end - stretch.start)
    points = carrier.at(middles)
    step = 1e-3 * (stretch.end - stretch.start)
    tangents = carrier.at(middles + step) - points
    across = np.cross(sheet.normals(points), tangents)
    across *= ASIDE * min(thickness, *(wall.thickness for wall in walls))
    across /= np.linalg.norm(np.cross(sheet.normals(points), tangents), axis=1, keepdims=True)
    held: set[int] = set()
    for sign in (1.0, -1.0):
        flat = sheet.flat(points + sign * across)
        inside = np.array([shapely.contains_xy(wall.region, flat[:, 0], flat[:, 1]) for wall in walls])
        if not inside.any(axis=0).all():
            return ()
        held.update(np.nonzero(inside.any(axis=1))[0].tolist())
    return tuple(walls[place] for place in sorted(held))


def _as_tee(
    topology: Topology, crossing: Crossing, web: Wall, flanges: tuple[Wall, ...], along: Stretch
) -> _Tee | None:
    """The tee, with the carrier on which the web is to end; None where it has no edge at the flange's face."""
    flange = flanges[0]
    carrier = topology.carrier(along.carrier)
    if isinstance(carrier, TubeCurve):
        return None  # at its bends the branch lies in the run's wall: no arm leads off its face there
    points = carrier.at(along.start + PROBES * (along.end - along.start))
    beyond = slab_edges(web, flange, points, crossing.gap.get(web.index, 0.0) + ASIDE * web.thickness)
    sides = []
    for sign, places in zip((1.0, -1.0), beyond):
        flat = web.sheet.flat(places)
        sides.append((int(shapely.contains_xy(web.region, flat[:, 0], flat[:, 1]).sum()), sign))
    count, side = max(sides)
    if not count:
        return None
    if web.index in crossing.gap:
        own = own_edge(topology, crossing, web, flange, side)
        if own is None or not is_filled(topology, web, flanges, points, side, own[0]):
            return None if own is None else _Tee(crossing, flanges, along, side, *own)
    table = flange.segment.solid.surfaces.surfaces
    edge = slab_edges(web, flange, points, 0.0)[0 if side > 0 else 1]
    away = [float(np.abs(signed_distance(table[face], edge)).max()) for face in flange.surface_ids]
    face = flange.surface_ids[int(np.argmin(away))]
    number = intersection(topology.carriers, table, web.sheet.surface_id, face, edge[2:3])
    return _Tee(crossing, flanges, along, side, 0.0, number)


# ---------------------------------------------------------------- the web cut back


def _cut_region(topology: Topology, web: Wall, tees: Sequence[_Tee]) -> PolygonLike:
    """The web's region less its parts within the slabs of the flanges it ends in."""
    grid = GRID * topology.carriers.reach
    lines = [drawn(topology, web.sheet, tee.number, web.region) for tee in tees]
    slabs = [strip(topology, web, tee.crossing, tee.along.start, tee.along.end, tee.gap) for tee in tees]
    slab = shapely.union_all(slabs, grid_size=grid)
    cut = shapely.union_all([web.region.boundary, *(line for line in lines if line is not None)], grid_size=grid)
    kept = []
    for cell in parts_of(shapely.polygonize(list(shapely.get_parts(cut)))):
        if web.region.contains(cell.representative_point()):
            if cell.intersection(slab).area <= WITHIN * cell.area:
                kept.append(cell)
    if not kept:
        names = ", ".join(sorted({wall.segment.id for tee in tees for wall in tee.flanges}))
        raise ConnectError(
            f"{web.segment.id} lies wholly within the slabs of {names}, expected a web that stands out of them: "
            "these joints must be extended"
        )
    return shapely.union_all(kept, grid_size=grid)


def _arms(topology: Topology, web: Wall, tee: _Tee) -> list[Arm]:
    """An arm for each stretch of the web's new outline that is on the tee's edge, beside its joint curve."""
    found = []
    for stretch in web.outline:
        if stretch.carrier == tee.number and _is_beside(topology, web, tee, stretch):
            arm = Arm(web, tee.flanges, tee.crossing, tee.along, stretch, tee.side, tee.gap)
            found.append(_part_of_ring(topology, arm) if stretch.whole and not tee.along.whole else arm)
    if not found:
        amid = topology.carrier(tee.along.carrier).at(np.array([0.5 * (tee.along.start + tee.along.end)]))[0]
        names = " and ".join(joint.id for joint in tee.crossing.joints)
        raise ConnectError(
            f"{web.segment.id} finds no edge at the face of {tee.flanges[0].segment.id} ({names}) near "
            f"{topology.place_text(amid)}, expected one: this joint must be extended"
        )
    return found


def _part_of_ring(topology: Topology, arm: Arm) -> Arm:
    """The arm with only that part of a closed edge which lies beside its joint curve."""
    curve, edge = topology.carrier(arm.along.carrier), topology.carrier(arm.edge.carrier)
    assert edge.period is not None
    beside = arm.edge_points(samples(topology, curve, arm.along.start, arm.along.end))
    ends = np.unwrap(edge.parameters(beside), period=edge.period)[[0, -1]]
    start, end = float(ends.min()), float(ends.max())
    first, last = edge.at(np.array([start, end]))
    return replace(arm, edge=replace(arm.edge, start=start, end=end, first=first, last=last, whole=False))


def _is_beside(topology: Topology, web: Wall, tee: _Tee, edge: Stretch) -> bool:
    """Whether part of the edge lies beside the tee's joint curve: within its slab, a little widened."""
    middles = edge.start + np.linspace(0.01, 0.99, 41) * (edge.end - edge.start)
    line = windowed(web.sheet, LineString(unwrapped(web.sheet, topology.carrier(edge.carrier).at(middles))))
    more = tee.gap + ASIDE * min(web.thickness, tee.flanges[0].thickness)
    slab = strip(topology, web, tee.crossing, tee.along.start, tee.along.end, more)
    return bool(line.intersection(slab).length > 0.01 * min(line.length, tee.along.end - tee.along.start))
