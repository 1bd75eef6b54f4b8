"""Second order over the labelled models with round faces: mid-side nodes on the true surfaces, no Jacobian under 0."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from assembling import assembled

from kernel.mesh.assembly import Assembly
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.quality import refuse_inverted
from kernel.mesh.shapes import integration_rule, jacobians
from kernel.segment.segments import CylinderShape
from kernel.solid.surfaces import CylinderSurface, FacetedSurface, Plane, signed_distance

CASES = Path(__file__).parents[1] / "cases"
SIZES = {"ball": 10.0, "cone_stout": 20.0, "ring_torus": 25.0, "pipe_thick": 20.0}
"""Coarser than the automatic size where there are many elements."""

ROUND = sorted(
    path.stem
    for path in CASES.glob("*.csg")
    if re.search(r"cylinder|sphere|rotate_extrude|\b(CYL|SPH|CON|TOR)\(", path.read_text())
)


def least_density(assembly: Assembly) -> float:
    """The smallest Jacobian at an integration point of any face or solid, over the largest of its element."""
    least = 1.0
    for block in assembly.mesh.blocks:
        dimension = ELEMENT_KINDS[block.kind].dimension
        if dimension == 1:
            continue
        found = jacobians(assembly.mesh.nodes[block.connectivity], integration_rule(block.kind))
        if dimension == 3:
            density = np.linalg.det(found)
        else:
            normal = np.cross(found[:, :, 0], found[:, :, 1])
            mean = normal.mean(axis=1)
            density = np.einsum("eqi,ei->eq", normal, mean / np.linalg.norm(mean, axis=1)[:, None])
        least = min(least, float((density.min(axis=1) / density.max(axis=1)).min()))
    return least


def middles_off(assembly: Assembly, tolerance: float) -> tuple[int, int]:
    """Edges of free faces whose corners all lie on a curved surface of their segment: how many, and of how many the
    mid-side node is not on it."""
    nodes = assembly.mesh.nodes
    checked = off = 0
    for segment in assembly.segments:
        blocks = [block for block in assembly.mesh.blocks if block.segment == segment.id]
        solids = [block for block in blocks if ELEMENT_KINDS[block.kind].dimension == 3]
        shells = [block for block in blocks if ELEMENT_KINDS[block.kind].dimension == 2]
        surfaces = [segment.solid.surfaces.surfaces[k] for k in np.unique(segment.solid.facets.surface)]
        curved = [surface for surface in surfaces if not isinstance(surface, Plane | FacetedSurface)]
        if isinstance(segment.shape, CylinderShape):
            shape = segment.shape
            middle = CylinderSurface(shape.axis, shape.axis_id, shape.mid_radius)
            for block in shells:  # every edge of a cylinder-plate is on its mid-surface
                checked += block.connectivity.size // 2
                off += int((np.abs(signed_distance(middle, nodes[block.connectivity.ravel()])) > tolerance).sum())
        for corners, mids in outer(solids):
            for surface in curved:
                on = (np.abs(signed_distance(surface, nodes[corners.ravel()])) < tolerance).reshape(corners.shape)
                faces = on.all(axis=1)
                checked += int(faces.sum()) * mids.shape[1]
                off += int((np.abs(signed_distance(surface, nodes[mids[faces].ravel()])) > tolerance).sum())
    return checked, off


def outer(blocks):
    """Faces that stand once, (corners, mid-side nodes), triangles and quadrilaterals apart."""
    faces = {3: [], 4: []}
    for block in blocks:
        kind = ELEMENT_KINDS[block.kind]
        place = {frozenset(edge): kind.n_corner + k for k, edge in enumerate(kind.edges)}
        for loop in kind.faces:
            sides = [place[frozenset((a, b))] for a, b in zip(loop, (*loop[1:], loop[0]))]
            faces[len(loop)].append(block.connectivity[:, [*loop, *sides]])
    for count, found in faces.items():
        if found:
            rows = np.concatenate(found)
            _, first, times = np.unique(np.sort(rows[:, :count], axis=1), axis=0, return_index=True, return_counts=True)
            free = rows[first[times == 1]]
            yield free[:, :count], free[:, count:]


@pytest.mark.parametrize("name", ROUND)
def test_mid_side_nodes_stand_on_the_true_surfaces(name):
    assembly, evaluated = assembled((CASES / f"{name}.csg").read_text(), order=2, size=SIZES.get(name))
    assert {kind for kind in assembly.mesh.count() if ELEMENT_KINDS[kind].order == 1} == set()
    refuse_inverted(assembly.mesh)
    assert least_density(assembly) > 0.1
    assert not any("drawn back" in warning for warning in assembly.warnings)
    checked, off = middles_off(assembly, 1e-9 * evaluated.size)
    assert off == 0
    round_solids = [s for s in assembly.segments if s.type in ("brick", "cylinder_plate")]
    assert checked > 0 or not any(
        isinstance(s.solid.surfaces.surfaces[k], CylinderSurface)
        for s in round_solids
        for k in np.unique(s.solid.facets.surface)
    )
