"""Ties: what the joints ask for once everything is meshed."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.footprints import edge_carriers, is_on_face
from kernel.idealise.parts import Parts
from kernel.idealise.tangent_lines import is_tangent
from kernel.idealise.walls import Wall
from kernel.mesh.assembly import Tie
from kernel.mesh.beam_ties import beam_on_beam, beam_on_brick, beam_on_wall
from kernel.mesh.meshed import Meshed, average, edge_nodes, interpolated, nodes_beside
from kernel.mesh.patches import SurfaceFaces, host_of
from kernel.solid.charts import flatten
from kernel.solid.surfaces import signed_distance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def make_ties(meshed: Meshed) -> tuple[Tie, ...]:
    """The ties of all joints that do not share nodes. ConnectError, by joint, where one cannot be made."""
    ties: list[Tie] = []
    walls: dict[tuple[str, str], list[Joint]] = {}
    for joint in meshed.parts.joints:
        if all(name in meshed.parts.walls for name in joint.segments):
            walls.setdefault(joint.segments, []).append(joint)
        else:
            ties += _joint_ties(meshed, joint)
    for (first, second), joints in walls.items():
        ties += _wall_on_wall(meshed, joints, meshed.parts.walls[first], meshed.parts.walls[second])
    return tuple(ties)


def _kinds(parts: Parts, joint: Joint) -> dict[str, list[str]]:
    kinds: dict[str, list[str]] = {"beam": [], "wall": [], "brick": []}
    for name in joint.segments:
        kinds["wall" if name in parts.walls else "beam" if name in parts.beams else "brick"].append(name)
    return kinds


def _joint_ties(meshed: Meshed, joint: Joint) -> list[Tie]:
    parts = meshed.parts
    kinds = _kinds(parts, joint)
    match (len(kinds["beam"]), len(kinds["wall"]), len(kinds["brick"])):
        case (2, 0, 0):
            return beam_on_beam(meshed, joint)
        case (1, 1, 0):
            return beam_on_wall(meshed, joint, parts.beams[kinds["beam"][0]], parts.walls[kinds["wall"][0]])
        case (1, 0, 1):
            return beam_on_brick(meshed, joint, parts.beams[kinds["beam"][0]], kinds["brick"][0])
        case (0, 1, 1):
            return _brick_on_wall(meshed, joint, parts.walls[kinds["wall"][0]], kinds["brick"][0])
        case _:
            return _brick_on_brick(meshed, joint)


# ---------------------------------------------------------------- walls


def _wall_on_wall(meshed: Meshed, joints: list[Joint], first: Wall, second: Wall) -> list[Tie]:
    """Nothing where the two share curves; else the nodes of the one in a contact follow the other's elements.

    joints: all contacts of the two. One of them must do: the largest first, the smaller wall's nodes first. A plate
    that is tangent to a tube amid both walls shares a line with it, and what else lies in the contact follows, too.
    """
    tangent = [joint for joint in joints if is_tangent(meshed.parts, joint)]
    own, others = (meshed.curves.get(wall.index, []) for wall in (first, second))
    if len(own) <= len(others):  # a floor has thousands of curves, what stands on it few
        is_shared = any(second.index in seeded.curve.uses for seeded in own)
    else:
        is_shared = any(first.index in seeded.curve.uses for seeded in others)
    if is_shared and not tangent:
        return []
    if any(first in arm.walls and second in arm.walls for arm in meshed.parts.arms):
        return []
    if _joined_through_others(meshed, first, second):
        return []
    by_area = sorted((first, second), key=lambda wall: (wall.region.area, wall.index))
    for joint in sorted(joints, key=lambda joint: (-joint.area, joint.id)):
        for follower, host in (by_area, by_area[::-1]):
            chosen = _contact_nodes(meshed, joint, follower, host)
            if is_shared:
                chosen = np.setdiff1d(chosen, meshed.faces[host.segment.id].nodes)
            if len(chosen) > 1:
                return [interpolated(meshed, joint, chosen, host, has_rotations=True)]
    return [] if is_shared else [_beside(meshed, joints, by_area)]


def _beside(meshed: Meshed, joints: list[Joint], walls: list[Wall]) -> Tie:
    """The nodes of one wall next to a contact follow the other's elements: of the one that has some nearest to it.

    So are walls joined whose mid-surfaces neither meet nor end in the contact. walls: the smaller one first.
    ConnectError where neither has nodes there.
    """
    tried = []
    for joint in joints:
        for place, follower in enumerate(walls):
            nodes, away = nodes_beside(meshed, follower, joint)
            chosen = np.setdiff1d(nodes, meshed.faces[walls[1 - place].segment.id].nodes)
            if len(chosen):
                tried.append((round(away / meshed.parts.topology.tolerance), -joint.area, place, joint, chosen))
    one, other = (wall.segment.id for wall in walls)
    if not tried:
        where = meshed.parts.topology.place_text(joints[0].centre)
        raise ConnectError(
            f"{one} and {other} touch ({', '.join(joint.id for joint in joints)}) near {where} without a common curve, "
            "and neither has nodes there that the other could hold: a smaller size or another type is needed for one "
            "of them"
        )
    _, _, place, joint, chosen = min(tried, key=lambda each: each[:3])
    names = (one, other) if place == 0 else (other, one)
    meshed.parts.warnings.append(
        f"{one} and {other} touch ({joint.id}) beside their mid-surfaces, near "
        f"{meshed.parts.topology.place_text(joint.centre)}: {len(chosen)} nodes of {names[0]} follow {names[1]}"
    )
    return interpolated(meshed, joint, chosen, walls[1 - place], has_rotations=True)


def _contact_nodes(meshed: Meshed, joint: Joint, follower: Wall, host: Wall) -> Indices:
    """Nodes of a wall within a contact: inside the patch of a lap, on the outline where the wall ends there."""
    if joint.kind == "lap":
        nodes = meshed.faces[follower.segment.id].nodes
        # a tube's far side looks the same way from the other's axis
        away = np.abs(signed_distance(meshed.surface(joint), meshed.points[nodes]))
        nodes = nodes[away <= follower.thickness]
        patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
    else:
        if not edge_carriers(meshed.parts, follower, joint):
            return np.empty(0, np.int64)
        nodes = np.array(edge_nodes(meshed, follower, joint), dtype=np.int64)
        patch = joint.patch.buffer(0.6 * max(follower.thickness, host.thickness))
    flat = flatten(meshed.surface(joint), meshed.points[nodes])
    return np.sort(nodes[shapely.contains_xy(patch, flat[:, 0], flat[:, 1])])


def _joined_through_others(meshed: Meshed, first: Wall, second: Wall) -> bool:
    """Whether the curve in which their mid-surfaces meet runs in a wall that continues one of the two.

    So it is where one wall was cut in two beside the joint: the curve lies in the one part, the contact reaches the
    other.
    """
    carriers = {crossing.carrier for crossing in meshed.parts.crossings_of(first) if second in crossing.walls}
    wanted = {first.sheet.surface_id, second.sheet.surface_id}
    hanging: dict[int, set[int]] = {}
    for arm in meshed.parts.arms:
        hanging.setdefault(arm.along.carrier, set()).add(arm.web.sheet.surface_id)
    for wall in meshed.parts.walls.values():
        if wall.sheet.surface_id in wanted:
            for seeded in meshed.curves.get(wall.index, []):
                sheets = {meshed.sheets[face] for face in seeded.curve.uses}
                sheets |= hanging.get(seeded.curve.carrier, set())
                if seeded.curve.carrier in carriers and wanted <= sheets:
                    return True
    return False


# ---------------------------------------------------------------- bricks


def _brick_on_wall(meshed: Meshed, joint: Joint, wall: Wall, brick: str) -> list[Tie]:
    pairs = meshed.bricks[brick].pairs
    host = meshed.parts.hosts.get(brick)
    if host is not None and host[1] is joint and len(pairs):
        return [Tie("rigid_pairs", joint, pairs[:, 0], pairs[:, 1], has_rotations=False)]
    faces = meshed.brick_faces(brick, joint)
    if is_on_face(wall, joint):
        patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
        nodes = faces.nodes
        flat = flatten(meshed.surface(joint), meshed.points[nodes])
        chosen = nodes[shapely.contains_xy(patch, flat[:, 0], flat[:, 1])]
        if len(chosen) < 3:
            raise ConnectError(
                f"{joint.id}: {brick} has {len(chosen)} nodes where it stands on {wall.segment.id}, expected 3 or "
                "more: a smaller size is needed there"
            )
        return [interpolated(meshed, joint, chosen, wall, has_rotations=False)]
    return _edge_on_brick(meshed, joint, wall, brick, faces)


def _edge_on_brick(meshed: Meshed, joint: Joint, wall: Wall, brick: str, faces: SurfaceFaces) -> list[Tie]:
    """Each node of the wall's edge follows, turning too, the part of the patch that is nearest to it."""
    nodes = np.array(edge_nodes(meshed, wall, joint), dtype=np.int64)
    surface, patch = faces.surface, joint.patch_of(brick)
    flat = flatten(surface, meshed.points[nodes])
    own: list[shapely.Geometry] = [patch] * len(nodes)
    if len(nodes) > 1:
        cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(flat), extend_to=patch.envelope))
        widened = shapely.STRtree(shapely.buffer(cells, 1e-9 * np.sqrt(shapely.area(cells))))
        inside, around = widened.query(shapely.points(flat), predicate="within")
        for place in range(len(nodes)):
            found = around[inside == place]
            if len(found):
                own[place] = patch.intersection(cells[found.min()])
    ties = []
    for node, part in zip(nodes.tolist(), own):
        if part.area > 1e-9 * patch.area:
            ties.append(average(joint, node, faces, part, wall.segment.id))
    return ties


def _brick_on_brick(meshed: Meshed, joint: Joint) -> list[Tie]:
    """Nothing where the two share nodes; else the nodes of the one whose face is the smaller follow the other's."""
    faces = {name: meshed.brick_faces(name, joint) for name in joint.segments}
    if len(np.intersect1d(faces[joint.segments[0]].nodes, faces[joint.segments[1]].nodes)) >= 3:
        return []
    covered = {name: sum(polygon.area for polygon in faces[name].polygons) for name in faces}
    small, large = sorted(joint.segments, key=lambda name: (covered[name], name))
    patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
    nodes = faces[small].nodes
    flat = flatten(meshed.surface(joint), meshed.points[nodes])
    inside = shapely.contains_xy(patch, flat[:, 0], flat[:, 1])
    chosen, at = nodes[inside], flat[inside]
    if len(chosen) < 3:
        raise ConnectError(
            f"{joint.id}: {small} has {len(chosen)} nodes in its contact with {large}, expected 3 or more: "
            "a smaller size is needed there"
        )
    hosts, weights = zip(*(host_of(faces[large], point) for point in at))
    return [Tie("interpolated", joint, chosen, hosts=tuple(hosts), host_weights=tuple(weights), has_rotations=False)]
