"""Element quality by the definitions of the Verdict library (Stimpson et al., Sandia report SAND2007-1751).

scaled_jacobian: smallest over the corners of Jacobian over product of edge lengths; 1 for the regular element (for
    triangles and wedges by the factor 2 / sqrt 3, for tets sqrt 2). Curved edges count by their tangents.
min_angle, max_angle: degrees, of triangles and quads; the largest angle of a dented quad is the reflex one.
aspect: triangles L p / (4 sqrt 3 A) and quads L p / (4 A), L the longest side and p the perimeter; tets the longest
    edge over 2 sqrt 6 inscribed radii; wedges and hexes the longest over the shortest edge.
skew: quads and hexes, largest cosine between the lines that join middles of opposite sides (faces).
warpage: quads, 1 - min of the cubed cosines between normals at opposite corners; 0 when flat.
length: of lines.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.elements import ELEMENT_KINDS, ElementKind
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.shapes import corner_rule, doubled_normals, family, jacobians

Array = NDArray[np.float64]

# the edges that leave each corner, as the corners at their other ends, right-handed
_LEAVING: dict[str, tuple[tuple[int, ...], ...]] = {
    "tri": ((1, 2), (2, 0), (0, 1)),
    "quad": ((1, 3), (2, 0), (3, 1), (0, 2)),
    "tet": ((1, 2, 3), (2, 0, 3), (0, 1, 3), (0, 2, 1)),
    "wedge": ((1, 2, 3), (2, 0, 4), (0, 1, 5), (5, 4, 0), (3, 5, 1), (4, 3, 2)),
    "hex": (
        (1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3),
    ),
}  # fmt: skip

_REGULAR = {"tri": 2 / np.sqrt(3), "quad": 1.0, "tet": np.sqrt(2), "wedge": 2 / np.sqrt(3), "hex": 1.0}

_OPPOSITE_FACES = (((0, 3, 7, 4), (1, 2, 6, 5)), ((0, 1, 5, 4), (3, 2, 6, 7)), ((0, 1, 2, 3), (4, 5, 6, 7)))


def mesh_quality(mesh: Mesh, *, allow_inverted: bool = False) -> dict[str, Any]:
    """{kind: {"count", measure: {"min", "p5", "mean", "p95", "max"}}} over the whole mesh.

    MeshError: an element is inverted (unless allowed); the segment and the place are named.
    """
    if not allow_inverted:
        refuse_inverted(mesh)
    result: dict[str, Any] = {}
    for kind in ELEMENT_KINDS:
        blocks = [block for block in mesh.blocks if block.kind == kind and len(block.connectivity)]
        if not blocks:
            continue
        together = ElementBlock("", kind, np.concatenate([block.connectivity for block in blocks]))
        result[kind] = {"count": len(together.connectivity)}
        for name, values in element_quality(together, mesh.nodes).items():
            result[kind][name] = _summary(values)
    return result


def element_quality(block: ElementBlock, nodes: Array) -> dict[str, Array]:
    """Every measure of the block's elements, each (n_element,)."""
    places = nodes[block.connectivity]
    name = family(block.kind)
    kind = ELEMENT_KINDS[block.kind]
    if name == "line":
        return {"length": np.linalg.norm(places[:, 1] - places[:, 0], axis=1)}
    edges = [places[:, b] - places[:, a] for a, b in kind.edges]
    lengths = np.stack([np.linalg.norm(edge, axis=1) for edge in edges], axis=1)
    measures = {"scaled_jacobian": scaled_jacobian(kind, places)}
    if name in ("tri", "quad"):
        angles = _angles(places[:, : kind.n_corner])
        largest = angles.max(axis=1)
        if name == "quad":  # the sides of a reflex corner enclose what is left of the full turn
            largest = np.where(_is_dented(places[:, :4]), 360 - largest, largest)
        measures |= {"min_angle": angles.min(axis=1), "max_angle": largest}
    measures["aspect"] = _aspect(name, places, lengths)
    if name == "quad":
        measures |= {"skew": _quad_skew(places), "warpage": _quad_warpage(places)}
    elif name == "hex":
        measures["skew"] = _hex_skew(places)
    return measures


def scaled_jacobian(kind: ElementKind, places: Array) -> Array:
    """(n_element,), negative where a corner is turned inside out. places: (n_element, n_node, 3)."""
    name = family(kind.name)
    ratios = []
    if kind.dimension == 2:
        normal = _normal(places[:, : kind.n_corner])
    for corner, others in enumerate(_LEAVING[name]):
        tangents = [_unit(_tangent(kind, places, corner, other)) for other in others]
        if kind.dimension == 2:
            ratios.append((np.cross(tangents[0], tangents[1]) * normal).sum(axis=1))
        else:
            ratios.append((np.cross(tangents[0], tangents[1]) * tangents[2]).sum(axis=1))
    if name == "hex":
        axes = [_unit(axis) for axis in _hex_axes(places)]
        ratios.append((np.cross(axes[0], axes[1]) * axes[2]).sum(axis=1))
    worst = np.min(ratios, axis=0) * _REGULAR[name]
    return np.clip(worst, -1.0, 1.0)


def refuse_inverted(mesh: Mesh) -> None:
    """MeshError where an element's Jacobian is not positive at all its nodes, with the segment and the place."""
    least = {}
    for name in {block.kind for block in mesh.blocks if ELEMENT_KINDS[block.kind].dimension > 1}:
        together = np.concatenate([block.connectivity for block in mesh.blocks if block.kind == name])
        least[name] = _least_jacobian(ELEMENT_KINDS[name], mesh.nodes[together]).min(initial=np.inf)
    for block in mesh.blocks:
        kind = ELEMENT_KINDS[block.kind]
        if least.get(block.kind, np.inf) > 0 or not len(block.connectivity):
            continue
        places = mesh.nodes[block.connectivity]
        bad = np.flatnonzero(~(_least_jacobian(kind, places) > 0))  # those of no number too
        if len(bad):
            x, y, z = places[bad[0]].mean(axis=0)
            raise MeshError(
                f"segment {block.segment}: {len(bad)} of {len(places)} {block.kind} elements are inverted, "
                f"the first at ({x:.6g}, {y:.6g}, {z:.6g})"
            )


def _least_jacobian(kind: ElementKind, places: Array) -> Array:
    """(n_element,) smallest Jacobian over the nodes; of shells against the element's mean normal."""
    jacobian = jacobians(places, corner_rule(kind.name))
    if kind.dimension == 3:
        least: Array = np.linalg.det(jacobian).min(axis=1)
        return least
    normal = _normal(places[:, : kind.n_corner])
    return np.einsum("eqi,ei->eq", np.cross(jacobian[:, :, 0], jacobian[:, :, 1]), normal).min(axis=1)


def _tangent(kind: ElementKind, places: Array, corner: int, other: int) -> Array:
    """From a corner along the edge to another: the chord, or the tangent of the parabola through the mid-side node."""
    if kind.order == 1:
        return places[:, other] - places[:, corner]
    edge = next(k for k, (a, b) in enumerate(kind.edges) if {a, b} == {corner, other})
    middle = places[:, kind.n_corner + edge]
    return 4 * middle - 3 * places[:, corner] - places[:, other]


def _normal(corners: Array) -> Array:
    """(n_element, 3) mean normal of triangles or quads, of unit length; zero where there is none."""
    return _unit(doubled_normals(corners))


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def _angles(corners: Array) -> Array:
    """(n_element, n_corner) inner angles in degrees."""
    forward = _unit(np.roll(corners, -1, axis=1) - corners)
    backward = _unit(np.roll(corners, 1, axis=1) - corners)
    return np.degrees(np.arccos(np.clip((forward * backward).sum(axis=2), -1, 1)))


def _is_dented(corners: Array) -> NDArray[np.bool_]:
    """(n_element,) whether a corner of a quad is reflex, seen along the mean normal."""
    forward, backward = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    areas: Array = np.einsum("eki,ei->ek", np.cross(forward, backward), _normal(corners))
    return np.asarray((areas < 0).any(axis=1))


def _aspect(name: str, places: Array, lengths: Array) -> Array:
    longest = lengths.max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        if name == "tri":
            doubled = np.linalg.norm(doubled_normals(places[:, :3]), axis=1)
            return longest * lengths.sum(axis=1) / (2 * np.sqrt(3) * doubled)
        if name == "quad":
            doubled = np.linalg.norm(doubled_normals(places[:, :4]), axis=1)
            return longest * lengths.sum(axis=1) / (2 * doubled)
        if name == "tet":
            a, b, c = (places[:, k] - places[:, 0] for k in (1, 2, 3))
            six_volumes = np.abs((np.cross(a, b) * c).sum(axis=1))
            faces = [np.cross(a, b), np.cross(b, c), np.cross(c, a), np.cross(b - a, c - a)]
            doubled = np.sum([np.linalg.norm(face, axis=1) for face in faces], axis=0)
            return longest * doubled / (2 * np.sqrt(6) * six_volumes)
        return longest / lengths.min(axis=1)


def _quad_skew(places: Array) -> Array:
    a = _unit(places[:, 1] + places[:, 2] - places[:, 0] - places[:, 3])
    b = _unit(places[:, 2] + places[:, 3] - places[:, 0] - places[:, 1])
    return np.abs((a * b).sum(axis=1))


def _quad_warpage(places: Array) -> Array:
    corners = places[:, :4]
    normals = _unit(np.cross(np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners))
    cosines = np.stack([(normals[:, 0] * normals[:, 2]).sum(axis=1), (normals[:, 1] * normals[:, 3]).sum(axis=1)])
    return np.clip(1 - (cosines**3).min(axis=0), 0, None)


def _hex_axes(places: Array) -> list[Array]:
    return [places[:, list(b)].sum(axis=1) - places[:, list(a)].sum(axis=1) for a, b in _OPPOSITE_FACES]


def _hex_skew(places: Array) -> Array:
    a, b, c = (_unit(axis) for axis in _hex_axes(places))
    return np.max([np.abs((p * q).sum(axis=1)) for p, q in ((a, b), (b, c), (c, a))], axis=0)


def _summary(values: Array) -> dict[str, float]:
    low, high = np.percentile(values, [5, 95])
    return {
        "min": float(values.min()),
        "p5": float(low),
        "mean": float(values.mean()),
        "p95": float(high),
        "max": float(values.max()),
    }
