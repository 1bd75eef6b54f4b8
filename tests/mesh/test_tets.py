"""Tetrahedra: guarded, checked, repeatable, on the true surfaces."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from kernel.csg.tree import Block, Boolean, Cone, CsgModel, CsgNode, Cylinder, Sphere
from kernel.errors import MeshError
from kernel.mesh import tetcache, tets
from kernel.mesh.boundary import boundary_triangles, closest_on_triangles
from kernel.mesh.fit import FittedTets, fit
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.order import curved, places_on
from kernel.mesh.shapes import corner_rule, integration_rule, jacobians, measures
from kernel.mesh.solid_tets import LOST_SHARE, mesh_solid
from kernel.mesh.tets import (
    VOLUME_TOLERANCE,
    check_surface,
    check_tets,
    default_envelope,
    run_guarded,
    tet_shapes,
    tet_volumes,
    tetrahedralise,
)
from kernel.solid.brep import brep_of
from kernel.solid.evaluate import evaluate
from kernel.solid.solid import Solid
from kernel.solid.surfaces import signed_distance

CUBE = evaluate(CsgModel(root=Block(size=(2, 2, 2)), source="-", language="json")).solid


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory):
    """A cache of the test run's own."""
    folder = tmp_path_factory.mktemp("cache")
    before = os.environ.get("CSGMESH_CACHE")
    os.environ["CSGMESH_CACHE"] = str(folder)
    yield folder
    if before is None:
        del os.environ["CSGMESH_CACHE"]
    else:
        os.environ["CSGMESH_CACHE"] = before


def solid_of(root: CsgNode) -> Solid:
    return evaluate(CsgModel(root=root, source="-", language="json")).solid


def at(x: float, y: float, z: float) -> np.ndarray:
    placement = np.eye(4)
    placement[:3, 3] = x, y, z
    return placement


BRACKET = Boolean(
    operation="difference",
    children=(
        Block(size=(40, 30, 40)),
        Block(size=(40, 40, 40), placement=at(10, -5, 10)),
        Cylinder(radius=4, height=50, placement=at(25, 15, -5)),
    ),
)


def test_a_cube_is_filled_and_its_boundary_is_closed() -> None:
    nodes, elements = tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.0)
    assert tet_volumes(nodes, elements).sum() == pytest.approx(8.0, rel=1e-2)
    assert (tet_volumes(nodes, elements) > 0.0).all()
    assert len(np.unique(elements)) == len(nodes)
    assert check_surface(nodes, boundary_triangles(elements)) == pytest.approx(tet_volumes(nodes, elements).sum())


def test_the_same_input_gives_the_same_bytes(cache, monkeypatch) -> None:
    one = tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.0)
    monkeypatch.setattr(tets, "_run", None)  # the second must come from the cache
    other = tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.0)
    assert one[0].tobytes() == other[0].tobytes() and one[1].tobytes() == other[1].tobytes()
    with pytest.raises(TypeError):
        tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.01)


def test_a_damaged_entry_is_made_anew(cache) -> None:
    before = set((cache / "tets").glob("*.npz"))
    tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.5)
    (entry,) = set((cache / "tets").glob("*.npz")) - before
    entry.write_bytes(entry.read_bytes()[:200])
    anew = tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 1.5)
    kept = tetcache.load(entry.stem)
    assert kept is not None
    assert kept[0].tobytes() == anew[0].tobytes() and kept[1].tobytes() == anew[1].tobytes()


def test_of_two_meshes_of_one_body_made_at_once_the_first_is_kept(cache) -> None:
    first, second = ((np.full((4, 3), value), np.zeros((1, 4), np.int64)) for value in (1.0, 2.0))
    assert tetcache.keep("raced", first) is first
    got = tetcache.keep("raced", second)
    assert (got[0] == 1.0).all()
    (cache / "tets" / "raced.npz").write_bytes(b"damaged")
    assert tetcache.keep("raced", second) is second
    again = tetcache.load("raced")
    assert again is not None and (again[0] == 2.0).all()


def test_what_killed_processes_left_goes_after_a_day(cache) -> None:
    old, new = cache / "tets" / "old.part", cache / "tets" / "new.part"
    for part in (old, new):
        part.parent.mkdir(exist_ok=True)
        part.write_bytes(b"half")
    os.utime(old, (1, 1))
    tetcache.keep("another", (np.zeros((4, 3)), np.zeros((1, 4), np.int64)))
    assert not old.exists() and new.exists()
    new.unlink()


def test_old_entries_go_when_the_cache_grows(cache, monkeypatch) -> None:
    monkeypatch.setenv("CSGMESH_CACHE", str(cache / "small"))
    monkeypatch.setattr(tetcache, "MAX_BYTES", 5000)
    mesh = np.zeros((100, 3)), np.zeros((10, 4), np.int64)
    for number in range(4):
        tetcache.keep(f"key{number}", mesh)
        path = cache / "small" / "tets" / f"key{number}.npz"
        if path.exists():
            os.utime(path, (number, number))
    assert tetcache.load("key0") is None
    assert tetcache.load("key3") is not None


def test_a_cache_that_cannot_be_written_does_no_harm(tmp_path, monkeypatch) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("CSGMESH_CACHE", str(tmp_path / "file"))
    tetcache.keep("key", (np.zeros((1, 3)), np.zeros((1, 4), np.int64)))
    assert tetcache.load("key") is None


BODIES = {
    "bracket": (BRACKET, 6.0),
    "ball": (Sphere(radius=10), 6.0),
    "cone": (Cone(bottom_radius=10, top_radius=0, height=20), 5.0),
    "cube": (Block(size=(2, 2, 2)), 1.0),
}

RECORDED = Path(__file__).with_name("recorded")
"""A mesh of each body as fTetWild gave it once: it gives another every time, so that what comes of one is no proof."""


def off_surface(solid: Solid, body: FittedTets) -> np.ndarray:
    """How far each boundary node is from the nearest of the solid's surfaces, as a share of the solid's size."""
    surfaces = [solid.surfaces.surfaces[k] for k in np.unique(solid.facets.surface)]
    outer = body.nodes[np.unique(boundary_triangles(body.tets))]
    distance: np.ndarray = np.min([np.abs(signed_distance(surface, outer)) for surface in surfaces], axis=0)
    return distance / solid.size


def second_order(body: FittedTets) -> tuple[float, int]:
    """Volume of the body's tets of second order, none of them inverted, and how many middles were drawn inwards."""
    mesh = Mesh(body.nodes, (ElementBlock("s", "tet4", body.tets),))
    second, drawn = curved(mesh, places_on(body.edges, body.middles))
    (block,) = second.blocks
    rule = integration_rule("tet10")
    places = second.nodes[block.connectivity]
    assert (measures(jacobians(places, corner_rule("tet10"))) > 0.0).all()
    return float((measures(jacobians(places, rule)) * rule.weights).sum()), drawn


@pytest.mark.parametrize("name", BODIES)
def test_boundary_and_mid_side_nodes_stand_on_the_true_surfaces(name) -> None:
    root, size = BODIES[name]
    solid = solid_of(root)
    with np.load(RECORDED / f"{name}.npz") as kept:
        nodes, elements = kept["nodes"], kept["tets"].astype(np.int64)
    body = fit(solid, nodes, elements, default_envelope(solid.volume, solid.area, solid.size, size))
    assert body.left == 0
    assert (tet_shapes(body.nodes, body.tets) > 0.1).all()
    assert off_surface(solid, body).max() < 1e-8
    volume, drawn = second_order(body)
    assert volume == pytest.approx(solid.true_volume, rel=2e-4)
    assert drawn == 0


@pytest.mark.parametrize("name", BODIES)
def test_whatever_the_mesher_gives_is_sound_and_its_nodes_beside_the_surface_are_counted(name) -> None:
    root, size = BODIES[name]
    solid = solid_of(root)
    body = mesh_solid(solid, size)
    assert (tet_shapes(body.nodes, body.tets) > 0.0).all()
    assert (off_surface(solid, body) > 1e-8).sum() <= body.left
    areas = np.array([solid.facets.areas[face.triangles].sum() for face in brep_of(solid).faces])
    assert (body.face_areas >= LOST_SHARE * areas).all()
    volume, drawn = second_order(body)
    assert drawn <= len(body.edges)
    assert volume == pytest.approx(solid.true_volume, rel=VOLUME_TOLERANCE)


def test_boundary_nodes_above_one_another_are_drawn_together() -> None:
    """Within its envelope the mesher may leave two: both moved onto the sphere would flatten what lies between."""
    import trimesh

    solid = solid_of(Sphere(radius=10))
    ball = trimesh.creation.icosphere(subdivisions=1, radius=10.0)
    points, faces = np.asarray(ball.vertices), np.asarray(ball.faces, np.int64)
    centre, below = len(points), len(points) + 1
    fan = faces[(faces == 0).any(axis=1)]
    fan = np.array([np.roll(face, -int(np.flatnonzero(face == 0)[0])) for face in fan])
    ring = [0]
    while len(ring) < len(fan):
        ring.append(int(np.flatnonzero(fan[:, 1] == fan[ring[-1], 2])[0]))
    fan = fan[ring]
    half = len(fan) // 2
    first, last = int(fan[0, 1]), int(fan[half - 1, 2])
    aside = points[fan[half:, 1:]].mean(axis=(0, 1)) - points[0]
    nodes = np.concatenate([points, [aside], [0.985 * points[0]]])
    shell = np.concatenate([faces[~(faces == 0).any(axis=1)], fan[half:], [[below, *face[1:]] for face in fan[:half]]])
    shell = np.concatenate([shell, [[0, first, below], [0, below, last]]])
    tets = np.stack([np.full(len(shell), centre), *shell.T], axis=1)
    assert (tet_volumes(nodes, tets) > 0.0).all()
    body = fit(solid, nodes, tets, 0.3)
    assert body.left == 0
    assert len(body.nodes) == len(nodes) - 1
    outer = np.unique(boundary_triangles(body.tets))
    assert np.linalg.norm(body.nodes[outer], axis=1) == pytest.approx(10.0, rel=1e-8)


def test_corners_of_the_solid_are_nodes() -> None:
    with np.load(RECORDED / "cube.npz") as kept:
        body = fit(CUBE, kept["nodes"], kept["tets"].astype(np.int64), 0.03)
    for corner in ((0, 0, 0), (2, 0, 0), (2, 2, 2)):
        assert np.linalg.norm(body.nodes - np.array(corner), axis=1).min() < 1e-9
    assert tet_volumes(body.nodes, body.tets).sum() == pytest.approx(8.0, rel=1e-9)


BAD_SURFACES = {
    "open": (CUBE.facets.vertices, CUBE.facets.triangles[:-1], "not closed"),
    "inside out": (CUBE.facets.vertices, CUBE.facets.triangles[:, ::-1], "expected more than 0"),
    "one triangle turned": (
        CUBE.facets.vertices,
        np.vstack([CUBE.facets.triangles[:1, ::-1], CUBE.facets.triangles[1:]]),
        "not consistently oriented",
    ),
    "not finite": (CUBE.facets.vertices * np.array([1, np.nan, 1]), CUBE.facets.triangles, "not finite"),
    "empty": (np.empty((0, 3)), np.empty((0, 3), np.int64), "expected at least four"),
    "names no vertex": (CUBE.facets.vertices, CUBE.facets.triangles + 5, "names vertex"),
    "flat shape": (CUBE.facets.vertices, CUBE.facets.triangles.ravel(), "expected (n, 3) and (m, 3)"),
    "pinched triangle": (CUBE.facets.vertices, np.array([[0, 0, 1]] * 4), "one vertex twice"),
}


@pytest.mark.parametrize("name", BAD_SURFACES)
def test_what_is_no_closed_body_never_reaches_the_mesher(name, monkeypatch) -> None:
    monkeypatch.setattr(tets, "_run", None)
    vertices, triangles, message = BAD_SURFACES[name]
    with pytest.raises(MeshError) as raised:
        tetrahedralise(vertices, triangles, 1.0)
    assert message in str(raised.value)


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf, 1e-4])
def test_sizes_that_make_no_sense_are_refused(size, monkeypatch) -> None:
    monkeypatch.setattr(tets, "_run", None)
    with pytest.raises(MeshError, match="expected"):
        tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, size)


def test_a_mesher_that_takes_too_long_is_stopped() -> None:
    with pytest.raises(MeshError, match=r"took longer than 0.2 s and was stopped"):
        tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 0.9, deadline=0.2)


def test_a_mesher_that_wants_too_much_memory_is_stopped() -> None:
    with pytest.raises(MeshError, match=r"mesher (ran out of the memory|failed|crashed)"):
        tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 0.8, memory=50_000_000)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", r"crashed \(SIGSEGV\)"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "was killed from outside"),
        ("import sys; sys.exit(139)", r"crashed \(SIGSEGV\)"),
        ("raise MemoryError", "ran out of the memory"),
        ("import sys; sys.stderr.write('no good\\n'); sys.exit(3)", "failed with status 3: no good"),
    ],
)
def test_every_way_that_the_child_may_end_is_named(code, message, tmp_path) -> None:
    with pytest.raises(MeshError, match=message):
        run_guarded(["-c", code], tmp_path, 20.0)


def test_nothing_is_left_behind(tmp_path, monkeypatch) -> None:
    import tempfile

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(MeshError):
        tetrahedralise(CUBE.facets.vertices, CUBE.facets.triangles, 0.7, deadline=0.1)
    assert list(tmp_path.iterdir()) == []


GOOD = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
    np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
)


@pytest.mark.parametrize(
    ("nodes", "elements", "volume", "message"),
    [
        (GOOD[0], np.empty((0, 4), np.int64), 0.5, "no elements"),
        (GOOD[0] * np.nan, GOOD[1], 0.5, "not finite"),
        (GOOD[0], np.array([[0, 1, 2, 3], [1, 2, 4, 3]]), 0.5, "flat or inverted"),
        (GOOD[0], GOOD[1], 0.7, "expected the same within"),
        (GOOD[0], np.array([[0, 1, 2, 3]] * 3), 0.5, "share a face"),
    ],
)
def test_a_bad_result_is_refused(nodes, elements, volume, message) -> None:
    with pytest.raises(MeshError, match=message):
        check_tets(nodes, elements, volume, 0.01)


def test_a_result_that_is_inside_out_as_a_whole_is_turned() -> None:
    nodes, elements = check_tets(GOOD[0], GOOD[1][:, [0, 2, 1, 3]], 0.5, 0.01)
    assert (tet_volumes(nodes, elements) > 0.0).all()


def test_nearest_places_on_triangles() -> None:
    triangle = np.tile(np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]), (4, 1, 1))
    points = np.array([[0.2, 0.2, 3.0], [2, -1, 1], [1, 1, 0], [-1, 0.5, 0]])
    expected = np.array([[0.2, 0.2, 0], [1, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]])
    assert closest_on_triangles(triangle, points) == pytest.approx(expected)


def test_the_child_dies_with_its_parent(tmp_path) -> None:
    """A mesher whose parent is killed does not go on alone, however early that was."""
    root = Path(tets.__file__).parents[2]
    script = (
        "import numpy as np\n"
        "from kernel.csg.tree import Sphere, CsgModel\n"
        "from kernel.solid.evaluate import evaluate\n"
        "from kernel.mesh.tets import tetrahedralise\n"
        "f = evaluate(CsgModel(root=Sphere(radius=10), source='-', language='json')).solid.facets\n"
        "tetrahedralise(f.vertices, f.triangles, 1.0)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], cwd=root, env={**os.environ, "TMPDIR": str(tmp_path)})
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
    try:
        wait_until(lambda: children.read_text().split() != [])
        (child,) = children.read_text().split()
    finally:
        parent.send_signal(signal.SIGKILL)
        parent.wait()
    wait_until(lambda: has_ended(child))


def wait_until(holds) -> None:
    """However slow the machine is: what ends this is the run of the tests being stopped."""
    for _ in range(6000):
        if holds():
            return
        time.sleep(0.05)
    raise AssertionError("it did not happen")


def has_ended(process: str) -> bool:
    """Gone, or a zombie that nobody has asked for."""
    try:
        return "Z" in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2][:3]
    except (FileNotFoundError, ProcessLookupError):
        return True
