"""Equations that equate work over the face where a beam meets a solid or a shell.

A unit force or moment on the beam's end stands, in the solid, for the stresses of beam theory over the section:
axial 1/A, bending z/I and y/I, shear and torsion from the section's own finite element solution. The beam's
displacement along that force is the work of these stresses on the face's displacements. McCune, Armstrong and
Robinson, "Mixed-dimensional coupling in finite element models", Int. J. Numer. Meth. Engng 49 (2000) 725-750.

The stresses are integrated over the element faces with their shape functions, as any load on a face is. (Gathered at
the nearest nodes instead, the peak stress at the joint of half a bar came out 1.25 times M / W; so it is 1.01.) Where
the element faces at hand do not cover the section, nodes that depend on another joint being left out, each node gets
the part of the section that lies nearest to it. The six resultants are then not exactly one; a last 6 x 6 correction
makes them so, and with them the six rigid motions free of strain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity

from kernel.connect.mass import section_axes
from kernel.errors import ConnectError
from kernel.idealise.outline import moments
from kernel.idealise.section import SectionProperties
from kernel.idealise.torsion import Warping, solve_warping
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import Mesh
from kernel.mesh.patches import shape_functions

Array = NDArray[np.float64]

COVERED = 0.98
"""Share of the section that the element faces must cover to carry its stresses."""

GAUSS = 4
"""Points along each side of an element face: enough for faces that the section covers in part."""

MAX_CONDITION = 1e6
"""Condition of the gathered forces' resultants: beyond it the nodes cannot carry all six."""


@dataclass(frozen=True, slots=True, eq=False)
class BeamFrame:
    """A beam's section at one of its nodes; axes: (3, 3) rows x, y, z in the model's frame."""

    section: SectionProperties
    axes: Array


def beam_frames(mesh: Mesh, nodes: Array, sections: Mapping[str, SectionProperties]) -> dict[int, BeamFrame]:
    """Frame of every beam node; a node of several beams has the first one's."""
    frames: dict[int, BeamFrame] = {}
    for block in mesh.blocks:
        section = sections.get(block.segment)
        if section is None or block.orientation is None:
            continue
        start, end = nodes[block.connectivity[:, 0]], nodes[block.connectivity[:, 1]]
        y, z = section_axes(start, end, block.orientation)
        for row, y_axis, z_axis in zip(block.connectivity, y, z):
            for node in row:
                frames.setdefault(int(node), BeamFrame(section, np.stack([np.cross(y_axis, z_axis), y_axis, z_axis])))
    return frames


def warping_of(section: SectionProperties) -> Warping:
    """Shear stresses of the section (its whole outline in one piece)."""
    polygon = getattr(section.outline, "geoms", [section.outline])[0]
    return solve_warping(polygon, moments(polygon))


def patch_faces(mesh: Mesh, patch: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n_face, 4) positions in `patch` of the corners of all element faces on it, triangles with the last one twice."""
    place = np.full(mesh.n_node, -1)
    place[patch] = np.arange(len(patch))
    found: dict[tuple[int, ...], list[int]] = {}
    for block in mesh.blocks:
        kind = ELEMENT_KINDS[block.kind]
        loops = {2: (tuple(range(kind.n_corner)),), 3: kind.faces}.get(kind.dimension, ())
        for loop in loops:
            rows = place[block.connectivity[:, list(loop)]]
            for row in rows[(rows >= 0).all(axis=1)].tolist():
                found.setdefault(tuple(sorted(row)), row if len(row) == 4 else [*row, row[-1]])
    return np.array([found[key] for key in sorted(found)], dtype=np.int64).reshape(-1, 4)


def work_matrix(
    section: SectionProperties, warping: Warping, axes: Array, points: Array, faces: NDArray[np.int64], place: str
) -> Array:
    """(6, n, 3): the beam end's displacements and rotations, global, from the translations of n face nodes.

    axes: (3, 3) rows x (along the beam), y and z of the section, global. points: (n, 3) of the face's nodes, from the
    beam's end. faces: (n_face, 4) positions of element faces' corners among them. ConnectError: the nodes cannot carry
    six independent forces; `place` names the joint.
    """
    local = points @ axes.T
    forces = _integrated(section, warping, local[:, 1:], faces)
    if forces is None:
        forces = _gathered(section, warping, local[:, 1:], faces)
    motions = np.zeros((6, len(points), 3))
    motions[:3] = np.eye(3)[:, None, :]
    motions[3:] = np.cross(np.eye(3)[:, None, :], local[None, :, :])
    resultants = np.einsum("fnk,mnk->fm", forces, motions)
    length = float(np.sqrt(section.area))
    scale = np.array([1.0, 1.0, 1.0, length, length, length])
    if np.linalg.cond(resultants * scale[:, None] / scale) > MAX_CONDITION:
        raise ConnectError(f"{place}: {len(points)} nodes of the face cannot carry a beam's six forces, expected more")
    local_rows = np.einsum("gf,fnk->gnk", np.linalg.inv(resultants), forces)
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = axes
    result: Array = np.einsum("gf,fnk->gnk", turn.T, local_rows @ axes)
    return result


def _integrated(
    section: SectionProperties, warping: Warping, flat: Array, faces: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """(6, n, 3) loads of the unit stresses on the nodes at `flat` (y, z); None: the faces do not cover the section."""
    at, weight = np.polynomial.legendre.leggauss(GAUSS)
    r, s = (values.ravel() for values in np.meshgrid(at, at))
    both = np.outer(weight, weight).ravel()
    shape = 0.25 * np.stack([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)], axis=1)
    by_r = 0.25 * np.stack([-(1 - s), 1 - s, 1 + s, -(1 + s)], axis=1)
    by_s = 0.25 * np.stack([-(1 - r), -(1 + r), 1 + r, 1 - r], axis=1)
    corners = flat[faces]  # (n_face, 4, 2)
    along, across = (np.einsum("qk,fkd->fqd", slope, corners) for slope in (by_r, by_s))
    area = np.abs(along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]) * both
    places = np.einsum("qk,fkd->fqd", shape, corners).reshape(-1, 2)
    outline = affinity.translate(section.outline, -section.centroid[0], -section.centroid[1])
    area = np.where(shapely.contains_xy(outline, places[:, 0], places[:, 1]).reshape(area.shape), area, 0.0)
    if area.sum() < COVERED * section.area:
        return None
    stress = _stresses(section, warping, places).reshape(6, len(faces), -1, 3)
    loads = np.einsum("gfqc,fq,qk->gfkc", stress, area, shape)
    forces = np.zeros((6, len(flat), 3))
    for force, load in zip(forces, loads):
        np.add.at(force, faces, load)
    return forces


def _gathered(section: SectionProperties, warping: Warping, flat: Array, faces: NDArray[np.int64]) -> Array:
    """(6, n, 3) loads of the unit stresses on the nodes at `flat` (y, z), from the points of the section's own mesh."""
    shares = np.zeros((len(warping.points), len(flat)))
    shares[np.arange(len(shares)), _nearest(warping.points, flat)] = 1.0
    loops = [face[: len(set(face.tolist()))] for face in faces]
    polygons = [shapely.Polygon(flat[loop]) for loop in loops]
    places, found = shapely.STRtree(polygons).query(shapely.points(warping.points), predicate="intersects")
    for place, face in zip(places.tolist(), found.tolist()):
        shares[place] = 0.0
        shares[place, loops[face]] = shape_functions(flat[loops[face]], warping.points[place])
    loads = _stresses(section, warping, warping.points) * warping.areas[:, None]
    return np.einsum("pn,fpc->fnc", shares, loads)


def _stresses(section: SectionProperties, warping: Warping, places: Array) -> Array:
    """(6, n_place, 3) stresses on the face (x, y, z), at places (n_place, 2), of unit forces along and moments about
    x, y, z. Shear is that of the nearest point of the warping solution.
    """
    y, z = places.T
    shear = warping.stress[:, _nearest(places, warping.points)]
    stress = np.zeros((6, len(y), 3))
    determinant = section.iyy * section.izz - section.iyz**2
    stress[0, :, 0] = 1 / section.area
    stress[1, :, 1:] = shear[1]
    stress[2, :, 1:] = shear[2]
    stress[3, :, 1:] = shear[0]
    stress[4, :, 0] = (section.izz * z - section.iyz * y) / determinant
    stress[5, :, 0] = -(section.iyy * y - section.iyz * z) / determinant
    return stress


def _nearest(points: Array, nodes: Array) -> NDArray[np.int64]:
    """The node nearest to each point, the first of equals."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(nodes).query(points)[1], dtype=np.int64)
