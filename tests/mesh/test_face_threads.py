"""Faces meshed in threads: the same bytes, and the same error, as one after the other."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from assembling import assembled, cube, union
from planar_regions import hole, rectangle, region

from kernel.errors import MeshError
from kernel.idealise.sheets import PlaneSheet
from kernel.mesh import faces
from kernel.mesh.region import Region, RegionMesh
from kernel.solid.surfaces import Plane

EAST, NORTH, UP = np.eye(3)
GROUND = PlaneSheet(0, Plane(UP, 0.0, EAST, NORTH), UP, 0.0, EAST, NORTH)


def test_a_box_of_plates_is_the_same_in_threads_byte_for_byte(monkeypatch: pytest.MonkeyPatch) -> None:
    ell = union(cube(60, 40, 2), cube(2, 40, 50), cube(60, 2, 50))
    names: set[str] = set()
    mesh_region = faces.mesh_region

    def watched(*given: object) -> RegionMesh:
        names.add(threading.current_thread().name)
        return mesh_region(*given)

    monkeypatch.setattr(faces, "mesh_region", watched)
    found = []
    for worth in (np.inf, 0.0):
        monkeypatch.setattr(faces, "WORTH_THREADS", worth)
        monkeypatch.setattr(faces.os, "cpu_count", lambda: 3)
        mesh = assembled(ell, size=4.0)[0].mesh
        found.append((mesh.nodes.tobytes(), [block.connectivity.tobytes() for block in mesh.blocks]))
    assert found[0] == found[1]
    assert len(found[0][1]) >= 3
    assert any(name.startswith("ThreadPoolExecutor") for name in names)


@pytest.mark.parametrize("worth", [0.0, np.inf])
def test_the_error_is_that_of_the_first_face_that_has_one(worth: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faces, "WORTH_THREADS", worth)
    monkeypatch.setattr(faces.os, "cpu_count", lambda: 2)

    def task(name: str, plane: Region) -> faces.FaceTask:
        return faces.FaceTask(name, GROUND, plane, np.arange(len(plane.points)), 1.0, "tri", None, np.eye(3))

    crossing = region([rectangle(10, 10, 1), hole(9.3, 5.1, 2, 1)])
    tasks = [task(f"s{k}", crossing if k in (1, 2) else region([rectangle(10, 10, 1)])) for k in range(4)]
    meshes = faces.mesh_all(tasks)
    assert len(next(meshes).triangles) > 100
    with pytest.raises(MeshError, match=r"^s1: an edge of the region meets another"):
        next(meshes)
