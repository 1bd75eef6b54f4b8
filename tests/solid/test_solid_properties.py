"""What must hold for every model: motions, mirrors, the order of operands and repetition change nothing."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trees import at, difference, evaluated, intersection, moved, turned, union

from kernel.csg.tree import Block, Boolean, Cone, CsgNode, Cylinder, Extrusion, Sphere, Wedge
from kernel.solid.brep import brep_of

L_PROFILE = (np.array([[0.0, 0], [40, 0], [40, 8], [8, 8], [8, 30], [0, 30]]),)


def bracket() -> Boolean:
    return difference(
        union(
            Block(size=(100, 60, 10)),
            Block(size=(10, 60, 80), placement=at(z=10)),
            Wedge(size=(40, 40, 8), placement=at(10, 34, 10, turned([1, 0, 0], 90))),
            Cylinder(radius=12, height=6, placement=at(70, 30, 10)),
        ),
        Cylinder(radius=8, height=40, placement=at(70, 30, -10)),
        Cylinder(radius=6, height=40, placement=at(-10, 30, 60, turned([0, 1, 0], 90))),
        Cone(bottom_radius=9, top_radius=3, height=12, placement=at(30, 12, -1)),
    )


def knob() -> Boolean:
    return union(
        difference(Sphere(radius=20), Cylinder(radius=6, height=60, placement=at(z=-30))),
        Extrusion(loops=L_PROFILE, height=25, placement=at(15, 0, -12)),
    )


MODELS = {"bracket": bracket, "knob": knob}


def shape_of(node: CsgNode) -> tuple[float, list[tuple[str, float]], int]:
    solid = evaluated(node).solid
    brep = brep_of(solid)
    faces = sorted((type(face.surface).__name__, face.area) for face in brep.faces)
    return solid.true_volume, faces, len(brep.edges)


def assert_same(one: CsgNode, other: CsgNode, scale: float = 1.0) -> None:
    volume, faces, n_edge = shape_of(one)
    volume2, faces2, n_edge2 = shape_of(other)
    assert volume2 == pytest.approx(volume * scale**3, rel=1e-8)
    assert [kind for kind, _ in faces2] == [kind for kind, _ in faces]
    assert [area for _, area in faces2] == pytest.approx([area * scale**2 for _, area in faces], rel=1e-6)
    assert n_edge2 == n_edge


UNIT = st.floats(-1, 1).filter(lambda x: abs(x) > 0.01)


@settings(max_examples=12)
@given(
    name=st.sampled_from(sorted(MODELS)),
    axis=st.tuples(UNIT, UNIT, UNIT),
    degrees=st.floats(-180, 180),
    shift=st.tuples(*[st.floats(-500, 500)] * 3),
)
def test_a_rigid_motion_keeps_volume_faces_and_edges(name, axis, degrees, shift) -> None:
    node = MODELS[name]()
    assert_same(node, moved(node, at(*shift, linear=turned(axis, degrees))))


@pytest.mark.parametrize("name", sorted(MODELS))
@pytest.mark.parametrize("mirror", [np.diag([-1.0, 1, 1]), turned([1, 1, 0], 30) @ np.diag([1.0, 1, -1])])
def test_a_mirror_keeps_volume_faces_and_edges(name, mirror) -> None:
    node = MODELS[name]()
    assert_same(node, moved(node, at(linear=mirror)))


@pytest.mark.parametrize("scale", [1e-3, 25.4])
def test_scaling_scales_volume_and_areas(scale) -> None:
    assert_same(bracket(), moved(bracket(), at(linear=scale * np.eye(3))), scale)


def shuffled(node: CsgNode, random) -> CsgNode:
    """The tree with operands that may be swapped in another order."""
    if not isinstance(node, Boolean):
        return node
    operands = [shuffled(operand, random) for operand in node.children]
    fixed = operands[:1] if node.kind == "difference" else []
    free = operands[len(fixed) :]
    random.shuffle(free)
    return Boolean(operation=node.operation, children=(*fixed, *free))


@settings(max_examples=15)
@given(name=st.sampled_from(sorted(MODELS)), random=st.randoms(use_true_random=False))
def test_shuffled_operands_give_the_same_solid_to_the_last_bit(name, random) -> None:
    one, other = evaluated(MODELS[name]()), evaluated(shuffled(MODELS[name](), random))
    assert other.solid.volume == one.solid.volume
    assert other.solid.true_volume == one.solid.true_volume
    assert np.array_equal(other.solid.facets.vertices, one.solid.facets.vertices)
    assert np.array_equal(other.solid.facets.surface, one.solid.facets.surface)
    for a, b in zip(brep_of(one.solid).faces, brep_of(other.solid).faces, strict=True):
        assert (a.surface_id, a.side, a.area) == (b.surface_id, b.side, b.area)


@settings(max_examples=25)
@given(
    corners=st.lists(
        st.tuples(*[st.integers(0, 6)] * 3, *[st.integers(1, 4)] * 3),
        min_size=2,
        max_size=7,
    )
)
def test_unions_of_blocks_have_the_volume_of_their_cells(corners) -> None:
    cells = np.zeros((10, 10, 10), bool)
    for x, y, z, a, b, c in corners:
        cells[x : x + a, y : y + b, z : z + c] = True
    blocks = [Block(size=(a, b, c), placement=at(x, y, z)) for x, y, z, a, b, c in corners]
    solid = evaluated(union(*blocks)).solid
    assert solid.volume == pytest.approx(cells.sum(), rel=1e-12)
    shown = sum(np.abs(np.diff(np.pad(cells, 1).astype(int), axis=axis)).sum() for axis in range(3))
    assert solid.area == pytest.approx(shown, rel=1e-12)


@settings(max_examples=15)
@given(st.lists(st.tuples(*[st.integers(0, 6)] * 3, *[st.integers(1, 4)] * 3), min_size=2, max_size=5), st.data())
def test_a_solid_is_its_difference_and_its_intersection_together(corners, data) -> None:
    blocks = [Block(size=(a, b, c), placement=at(x, y, z)) for x, y, z, a, b, c in corners]
    tool = Cylinder(radius=data.draw(st.floats(0.5, 4)), height=20, placement=at(3, 3, -1))
    body = union(*blocks)
    result = evaluated(union(body, tool))
    taken = result.solid_of_operands("difference", (body, tool))
    shared = result.solid_of(intersection(body, tool))
    assert taken.true_volume + shared.true_volume == pytest.approx(result.solid_of(body).true_volume, rel=1e-9)


PRINT = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
from test_solid_properties import MODELS
from trees import evaluated
from kernel.solid.export import ENDINGS, solid_bytes
for name in sorted(MODELS):
    result = evaluated(MODELS[name]())
    print(result.solid.true_volume.hex(), *(hashlib.sha256(solid_bytes(result, e)).hexdigest() for e in ENDINGS))
"""


def test_two_processes_with_other_hash_seeds_write_the_same_bytes() -> None:
    from pathlib import Path

    here = str(Path(__file__).parent)
    written = {
        subprocess.run(
            [sys.executable, "-c", PRINT, here],
            env={"PYTHONHASHSEED": seed, "PATH": ""},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(written) == 1
    assert len(written.pop().split()) == 10
