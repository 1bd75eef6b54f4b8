"""Where a place lies in a mesh: on a beam, in a shell, on an edge; and the nearest place where it lies on none."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import Mesh
from kernel.mesh.shapes import shape_derivatives, shape_values

Array = NDArray[np.float64]

EDGE_SHARE = 0.05
"""Chords of arcs leave their arcs by less than this share of their length: nodes are at most 45 degrees apart."""

NEWTON_STEPS = 15


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """block, element: where. local: (dimension,) reference coordinates; place: (3,) on the element, `distance` away."""

    block: int
    element: int
    local: Array
    place: Array
    distance: float


def nearest_element(mesh: Mesh, place: Array, dimensions: Collection[int], segment: str | None = None) -> Found | None:
    """The element of one of the dimensions (1, 2) nearest to a place; the first of those equally near."""
    best: Found | None = None
    for number, block in enumerate(mesh.blocks):
        kind = ELEMENT_KINDS[block.kind]
        if kind.dimension not in dimensions or segment not in (None, block.segment) or not len(block.connectivity):
            continue
        places = mesh.nodes[block.connectivity]
        extent = np.linalg.norm(np.ptp(places, axis=1), axis=1)
        outside = np.maximum(np.maximum(places.min(axis=1) - place, place - places.max(axis=1)), 0)
        least = np.maximum(np.linalg.norm(outside, axis=1) - EDGE_SHARE * extent, 0)  # curved ones bulge out
        for element in np.argsort(least, kind="stable").tolist():
            if best is not None and least[element] >= best.distance:
                break
            local, on = project_on(block.kind, places[element], place)
            distance = float(np.linalg.norm(place - on))
            if best is None or distance < best.distance * (1 - 1e-9):
                best = Found(number, element, local, on, distance)
    return best


def project_on(kind: str, corners: Array, place: Array) -> tuple[Array, Array]:
    """Reference coordinates and place of the point of a line or shell element that is nearest to a place.

    corners: (n_node, 3) of the element's nodes.
    """
    dimension = ELEMENT_KINDS[kind].dimension
    is_triangle = kind.startswith("tri")
    local = np.full(2, 1 / 3) if is_triangle else np.zeros(dimension)
    for _ in range(NEWTON_STEPS):
        off = place - shape_values(kind, local[None])[0] @ corners
        tangents = shape_derivatives(kind, local[None])[0] @ corners
        before, local = local, inside(is_triangle, local + np.linalg.lstsq(tangents.T, off, rcond=None)[0])
        if np.abs(local - before).max() < 1e-14:
            break
    candidates = [local]
    if dimension == 2:
        candidates += [_on_edge(kind, corners, place, edge) for edge in range(ELEMENT_KINDS[kind].n_corner)]
    values = [shape_values(kind, candidate[None])[0] @ corners for candidate in candidates]
    nearest = int(np.argmin([np.linalg.norm(place - value) for value in values]))
    return candidates[nearest], values[nearest]


def inside(is_triangle: bool, local: Array) -> Array:
    """Reference coordinates brought back into the element."""
    if not is_triangle:
        return np.clip(local, -1.0, 1.0)
    local = np.maximum(local, 0.0)
    return local / max(1.0, float(local.sum()))


_CORNERS = {
    3: np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    4: np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
}


def edge_local(kind: str, edge: int, share: float) -> Array:
    """Reference coordinates on an edge of a shell element, share 0..1 of the way along it."""
    reference = _CORNERS[ELEMENT_KINDS[kind].n_corner]
    a, b = ELEMENT_KINDS[kind].edges[edge]
    at: Array = (1 - share) * reference[a] + share * reference[b]
    return at


def _on_edge(kind: str, corners: Array, place: Array, edge: int) -> Array:
    """The point of an edge nearest to a place."""
    share = 0.5
    reach = edge_local(kind, edge, 1.0) - edge_local(kind, edge, 0.0)
    for _ in range(NEWTON_STEPS):
        local = edge_local(kind, edge, share)[None]
        off = place - shape_values(kind, local)[0] @ corners
        tangent = (reach @ shape_derivatives(kind, local)[0]) @ corners
        before, share = share, float(np.clip(share + off @ tangent / (tangent @ tangent), 0.0, 1.0))
        if abs(share - before) < 1e-14:
            break
    return edge_local(kind, edge, share)
