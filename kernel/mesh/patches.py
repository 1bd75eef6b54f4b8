"""Element faces on a surface: which of them a patch covers, how much each node gets of it, and where points lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.solid.charts import flat_faces, over_seams
from kernel.solid.surfaces import Surface, signed_distance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_GAUSS = 1 / np.sqrt(3)


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceFaces:
    """Element faces that lie on a surface. corners: node numbers of each, 3 or 4; flat: their coordinates.

    Faces that reach over a seam of the surface's chart are there twice, once on each of its sides.

    surface: whose; tree: over the flat polygons.
    """

    surface: Surface
    corners: tuple[Indices, ...]
    flat: tuple[Array, ...]
    polygons: NDArray[np.object_]
    tree: shapely.STRtree

    @property
    def nodes(self) -> Indices:
        """All their nodes, sorted."""
        return np.unique(np.concatenate(self.corners)) if self.corners else np.empty(0, np.int64)


def faces_on(surface: Surface, groups: Sequence[Indices], points: Array, tolerance: float) -> SurfaceFaces:
    """Those faces (arrays of corners) whose nodes all lie within `tolerance` of the surface. points: of all nodes."""
    corners: list[Indices] = []
    flat: list[Array] = []
    for group in groups:
        if not len(group):
            continue
        used, place = np.unique(group, return_inverse=True)
        on = np.abs(signed_distance(surface, points[used])) <= tolerance
        rows = group[on[place.reshape(group.shape)].all(axis=1)]
        unbroken, shown = flat_faces(surface, points[rows])
        rows, unbroken = rows[shown], unbroken[shown]
        copies, which = over_seams(surface, unbroken)  # a patch ends at the seam, on either side of it
        for nodes, at in zip(np.concatenate([rows, rows[which]]), np.concatenate([unbroken, copies])):
            # next to where a chart tears a quad may cross itself in it: its halves do not
            is_torn = len(at) == 4 and not shapely.Polygon(at).is_valid
            halves = ([0, 1, 2], [0, 2, 3]) if is_torn else (list(range(len(at))),)
            corners += [nodes[half] for half in halves]
            flat += [at[half] for half in halves]
    polygons = np.array([shapely.Polygon(face) for face in flat], dtype=object)
    return SurfaceFaces(surface, tuple(corners), tuple(flat), polygons, shapely.STRtree(polygons))


def shape_functions(corners: Array, point: Array) -> Array:
    """Weights (3,) or (4,) of a triangle's or quad's corners (n, 2) at a point (2,), linear or bilinear."""
    if len(corners) == 3:
        system = np.vstack([corners.T, np.ones(3)])
        return np.linalg.solve(system, np.array([*point, 1.0]))
    r = s = 0.0
    for _ in range(30):
        weights = 0.25 * np.array([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)])
        by_r = 0.25 * np.array([-(1 - s), 1 - s, 1 + s, -(1 + s)])
        by_s = 0.25 * np.array([-(1 - r), -(1 + r), 1 + r, 1 - r])
        step = np.linalg.solve(np.stack([by_r @ corners, by_s @ corners], axis=1), weights @ corners - point)
        r, s = float(np.clip(r - step[0], -3, 3)), float(np.clip(s - step[1], -3, 3))
        if np.abs(step).max() < 1e-14:
            break
    return 0.25 * np.array([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)])


def corner_areas(corners: Array) -> Array:
    """The integrals (n,) of a triangle's or quad's shape functions over it: what of its area falls to each corner."""
    if len(corners) == 3:
        first, second = corners[1] - corners[0], corners[2] - corners[0]
        return np.full(3, abs(first[0] * second[1] - first[1] * second[0]) / 6)
    result = np.zeros(4)
    for r in (-_GAUSS, _GAUSS):
        for s in (-_GAUSS, _GAUSS):
            by_r = 0.25 * np.array([-(1 - s), 1 - s, 1 + s, -(1 + s)]) @ corners
            by_s = 0.25 * np.array([-(1 - r), -(1 + r), 1 + r, 1 - r]) @ corners
            weights = 0.25 * np.array([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)])
            result += weights * abs(by_r[0] * by_s[1] - by_r[1] * by_s[0])
    return result


def node_areas(faces: SurfaceFaces, patch: shapely.Geometry) -> tuple[Indices, Array]:
    """Nodes of the faces that the patch covers, and the part of its area that falls to each."""
    areas: dict[int, float] = {}
    for index in sorted(faces.tree.query(patch).tolist()):
        common = patch.intersection(faces.polygons[index])
        if common.area <= 1e-9 * faces.polygons[index].area:
            continue
        middle = np.array([common.centroid.x, common.centroid.y])
        for node, weight in zip(faces.corners[index].tolist(), shape_functions(faces.flat[index], middle)):
            areas[node] = areas.get(node, 0.0) + float(weight) * common.area
    kept = {node: area for node, area in sorted(areas.items()) if area > 1e-9 * patch.area}
    return np.fromiter(kept, np.int64, len(kept)), np.fromiter(kept.values(), np.float64, len(kept))


def host_of(faces: SurfaceFaces, point: Array) -> tuple[Indices, Array]:
    """The face nearest to a point (2,), as its nodes and their weights there (held within the face)."""
    index = int(faces.tree.nearest(shapely.Point(point)))
    weights = np.clip(shape_functions(faces.flat[index], point), 0.0, None)
    return faces.corners[index], weights / weights.sum()
