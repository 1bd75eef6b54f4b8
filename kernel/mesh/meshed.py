"""What has been meshed so far, as the ties ask for it: element faces on surfaces, nodes on edges, averages."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.footprints import edge_carriers
from kernel.idealise.parts import Parts
from kernel.idealise.walls import Wall, patch_points
from kernel.mesh.assembly import Tie
from kernel.mesh.beams import SeatedNode
from kernel.mesh.bricks import BrickMesh, outer_faces
from kernel.mesh.faces import CurvesByFace, FaceMesh
from kernel.mesh.patches import SurfaceFaces, faces_on, host_of, node_areas
from kernel.solid.charts import flatten
from kernel.solid.surfaces import (
    ConeSurface,
    CylinderSurface,
    FacetedSurface,
    Plane,
    SphereSurface,
    Surface,
    TorusSurface,
    signed_distance,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

ON_SURFACE = 1e-6
"""Nodes nearer than this share of the model's size to a surface lie on it."""

LONGEST_ARM = 3.0
"""Nodes follow others over no longer arm than this many times the thicknesses of the walls that touch: as far as a
mid-surface may be cut back from a corner of them."""


@dataclass(slots=True, eq=False)
class Meshed:
    """What has been meshed. points: of all nodes. seated: the beams' nodes that sit on wall nodes.

    curves: of each wall, by its face. sheets: by face, the id of its mid-surface.
    """

    parts: Parts
    curves: CurvesByFace
    faces: dict[str, FaceMesh]
    bricks: dict[str, BrickMesh]
    seated: dict[str, list[SeatedNode]]
    points: Array
    sheets: dict[int, int] = field(init=False)
    _outer: dict[str, list[Indices]] = field(default_factory=dict)
    _on: dict[tuple[str, int], SurfaceFaces] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.sheets = {wall.index: wall.sheet.surface_id for wall in self.parts.walls.values()}

    def surface(self, joint: Joint) -> Surface:
        """The joint's surface."""
        return self.surface_of(joint, joint.segments[0])

    def surface_of(self, joint: Joint, name: str) -> Surface:
        """The surface that the segment of that id has at the joint."""
        return self.parts.segments[name].solid.surfaces.surfaces[joint.surface_of(name)]

    def wall_faces(self, wall: Wall) -> SurfaceFaces:
        """A wall's elements, on its mid-surface."""
        key = (wall.segment.id, -1)
        if key not in self._on:
            face = self.faces[wall.segment.id]
            tolerance = ON_SURFACE * self.parts.topology.carriers.reach
            self._on[key] = faces_on(wall.sheet.surface, (face.triangles, face.quads), self.points, tolerance)
        return self._on[key]

    def brick_faces(self, name: str, joint: Joint) -> SurfaceFaces:
        """A brick's element faces on the joint's surface."""
        key = (name, joint.surface_of(name))
        if key not in self._on:
            if name not in self._outer:
                self._outer[name] = outer_faces(self.bricks[name].blocks)
            size = self.parts.topology.carriers.reach
            surface = self.parts.segments[name].solid.surfaces.surfaces[joint.surface_of(name)]
            tolerance = ON_SURFACE * size
            if isinstance(surface, CylinderSurface | SphereSurface):
                tolerance = max(tolerance, 5e-3 * surface.radius)
            elif isinstance(surface, TorusSurface):
                tolerance = max(tolerance, 5e-3 * surface.minor_radius)
            elif isinstance(surface, ConeSurface):
                tolerance = max(tolerance, 5e-3 * float(np.sqrt(joint.area)))
            self._on[key] = faces_on(surface, self._outer[name], self.points, tolerance)
            if not self._on[key].corners:
                raise ConnectError(f"{name} has no element face on the surface of its joint {joint.id}")
        return self._on[key]


def edge_nodes(meshed: Meshed, wall: Wall, joint: Joint) -> list[int]:
    """Nodes on the wall's outline that lie on the joint's surface, within its patch seen along the wall's normal.

    Where the joint with a third wall has taken that edge up, as the step at a corner of a housing under its flange,
    the outline's nodes in the contact that are nearest to it.
    """
    numbers = set(edge_carriers(meshed.parts, wall, joint))
    points = patch_points(meshed.surface(joint), joint.patch)
    found: set[int] = set()
    slack = 8 * meshed.parts.topology.tolerance
    for seeded in meshed.curves.get(wall.index, []):
        if seeded.curve.carrier not in numbers:
            continue
        carrier = meshed.parts.topology.carrier(seeded.curve.carrier)
        if carrier.period is not None:
            found.update(seeded.nodes.tolist())
            continue
        reach = carrier.parameters(points)
        values = carrier.parameters(meshed.points[seeded.nodes])
        inside = (values >= reach.min() - slack) & (values <= reach.max() + slack)
        found.update(seeded.nodes[inside].tolist())
    found = found or _nearest_in_contact(meshed, wall, joint)
    if not found:
        found.update(nodes_beside(meshed, wall, joint)[0].tolist())
    if not found:
        other = next(name for name in joint.segments if name != wall.segment.id)
        raise ConnectError(
            f"{joint.id}: {other} and {wall.segment.id} touch near {meshed.parts.topology.place_text(joint.centre)}, "
            f"where {wall.segment.id} has no nodes within {LONGEST_ARM:g} thicknesses, expected some: a smaller size "
            "or another type is needed for one of them"
        )
    return sorted(found)


def _nearest_in_contact(meshed: Meshed, wall: Wall, joint: Joint) -> set[int]:
    surface = meshed.surface(joint)
    nodes = np.unique(np.concatenate([np.empty(0, np.int64), *(c.nodes for c in meshed.curves.get(wall.index, []))]))
    if not len(nodes) or not isinstance(surface, Plane | CylinderSurface):
        return set()
    flat = flatten(surface, meshed.points[nodes])
    away = np.abs(signed_distance(surface, meshed.points[nodes]))
    patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
    in_contact = shapely.contains_xy(patch, flat[:, 0], flat[:, 1]) & (away <= 1.5 * wall.thickness)
    if not in_contact.any():
        return set()
    return set(nodes[in_contact & (away <= away[in_contact].min() + 8 * meshed.parts.topology.tolerance)].tolist())


def nodes_beside(meshed: Meshed, wall: Wall, joint: Joint) -> tuple[Indices, float]:
    """Nodes of a wall's mid-surface next to a contact, and how far the nearest is from it; none beyond LONGEST_ARM.

    Where a wall was cut back, or its material by the contact is thinner than the wall itself, its mid-surface ends
    beside the contact. What lies no further from it than half the thicknesses of both does not lie there by chance,
    and nothing beyond the nearest node does where that is further.
    """
    surface, patch = meshed.surface_of(joint, wall.segment.id), joint.patch_of(wall.segment.id)
    if isinstance(surface, FacetedSurface):
        return np.empty(0, np.int64), np.inf
    thickness = sum(meshed.parts.walls[name].thickness for name in joint.segments if name in meshed.parts.walls)
    nodes = meshed.faces[wall.segment.id].nodes
    flat = flatten(surface, meshed.points[nodes])
    aside = shapely.distance(patch, shapely.points(flat))
    away = np.hypot(aside, signed_distance(surface, meshed.points[nodes]))
    nearest = float(away.min())
    if nearest > LONGEST_ARM * thickness:
        return np.empty(0, np.int64), nearest
    return nodes[away <= max(nearest * (1 + ON_SURFACE), 0.5 * thickness)], nearest


def average(joint: Joint, node: int, faces: SurfaceFaces, patch: shapely.Geometry, name: str) -> Tie:
    """A node that follows the part of some element faces that a patch covers; name: of its segment, for errors."""
    nodes, areas = node_areas(faces, patch)
    if not len(nodes):
        raise ConnectError(f"{joint.id}: {name} covers no element face of what it stands on")
    return Tie("beam_on_face", joint, np.array([node]), nodes, areas)


def interpolated(meshed: Meshed, joint: Joint, nodes: Indices, wall: Wall, has_rotations: bool) -> Tie:
    """Nodes that follow the elements of a wall, each the one that is nearest to it seen along the wall's normal."""
    faces = meshed.wall_faces(wall)
    flat = flatten(wall.sheet.surface, meshed.points[nodes])
    hosts, weights = zip(*(host_of(faces, point) for point in flat))
    return Tie(
        "interpolated",
        joint,
        nodes,
        hosts=tuple(hosts),
        host_weights=tuple(weights),
        has_rotations=has_rotations,
    )
