"""Equations that equate work over the face where a beam meets a solid or a shell.

A unit force or moment on the beam's end stands, in the solid, for the stresses of beam theory over the section:
axial 1/A, bending z/I and y/I, shear and torsion from the section's own finite element solution. The beam's
displacement along that force is the work of these stresses on the face's displacements. McCune, Armstrong and
Robinson, "Mixed-dimensional coupling in finite element models", Int. J. Numer. Meth. Engng 49 (2000) 725-750.

The stresses are gathered at the face's nodes, each from the part of the section that lies nearest to it. Their moments
are then not exactly one; a last 6 x 6 correction makes them so, and with them the six rigid motions free of strain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.connect.mass import section_axes
from kernel.errors import ConnectError
from kernel.idealise.outline import moments
from kernel.idealise.section import SectionProperties
from kernel.idealise.torsion import Warping, solve_warping
from kernel.mesh.mesh import Mesh

Array = NDArray[np.float64]

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


def work_matrix(section: SectionProperties, warping: Warping, axes: Array, points: Array, place: str) -> Array:
    """(6, n, 3): the beam end's displacements and rotations, global, from the translations of n face nodes.

    axes: (3, 3) rows x (along the beam), y and z of the section, global. points: (n, 3) of the face's nodes, from the
    beam's end. ConnectError: the nodes cannot carry six independent forces; `place` names the joint.
    """
    local = points @ axes.T
    stress = _stresses(section, warping)  # (6, n_point, 3)
    nearest = _nearest(warping.points, local[:, 1:])
    forces = np.zeros((6, len(points), 3))
    for force, field in zip(forces, stress):
        np.add.at(force, nearest, field * warping.areas[:, None])
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


def _stresses(section: SectionProperties, warping: Warping) -> Array:
    """(6, n_point, 3) stresses on the face (x, y, z) of unit forces along and moments about x, y, z."""
    y, z = warping.points.T
    stress = np.zeros((6, len(y), 3))
    determinant = section.iyy * section.izz - section.iyz**2
    stress[0, :, 0] = 1 / section.area
    stress[1, :, 1:] = warping.stress[1]
    stress[2, :, 1:] = warping.stress[2]
    stress[3, :, 1:] = warping.stress[0]
    stress[4, :, 0] = (section.izz * z - section.iyz * y) / determinant
    stress[5, :, 0] = -(section.iyy * y - section.iyz * z) / determinant
    return stress


def _nearest(points: Array, nodes: Array) -> NDArray[np.int64]:
    """The node nearest to each point, the first of equals."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(nodes).query(points)[1], dtype=np.int64)
