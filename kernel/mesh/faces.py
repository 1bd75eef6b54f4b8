"""Faces meshed on the shared curves: a node is a vertex, a place on a curve, or inside one face."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.mesh.congruent import Meshes
from kernel.mesh.nodes import NodeTable
from kernel.mesh.planar import GROWTH, enclosed_area, mesh_region
from kernel.mesh.region import OddCurveError, Region, RegionError, RegionMesh
from kernel.places import place_text

WORTH_THREADS = 20_000
"""Elements, roughly, from which faces are meshed in threads: fewer are done before the threads have started."""

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class SeededCurve:
    """A curve and its nodes (n,), from its first vertex to its second. parameters: theirs on the carrier."""

    curve: Curve
    nodes: Indices
    parameters: Array
    is_curved: bool


CurvesByFace = Mapping[int, Sequence[SeededCurve]]


@dataclass(frozen=True, slots=True, eq=False)
class FaceMesh:
    """nodes: (n,) numbers in the node table; flat: (n, 2) where they are in the sheet.

    quads (q, 4), triangles (t, 3): node numbers, counter-clockwise about the sheet's normal.
    """

    nodes: Indices
    flat: Array
    quads: Indices
    triangles: Indices


def odd_seeds_note(name: str, curves: Sequence[SeededCurve], kind: str, n_triangle: int, what: str) -> list[str]:
    """A line for the user where an odd number of seeds, which only he can have asked for, left triangles in a face."""
    if kind != "quad" or not n_triangle or all(len(seeded.nodes) % 2 for seeded in curves):
        return []
    return [f"{name}: an odd number of seeds on a curve leaves {n_triangle} {what}; an even number gives all quads"]


def curves_by_face(curves: Sequence[SeededCurve]) -> dict[int, list[SeededCurve]]:
    """The curves that each face uses, in their order."""
    found: dict[int, list[SeededCurve]] = {}
    for seeded in curves:
        for face in seeded.curve.uses:
            found.setdefault(face, []).append(seeded)
    return found


def face_region(face: int, sheet: Sheet, curves: Sequence[SeededCurve], points: Array) -> tuple[Region, Indices]:
    """The region of a face, and the node number of each of its points. points: of all nodes, (n, 3)."""
    local: dict[int, int] = {}
    edges: list[tuple[int, int]] = []
    boundary: list[bool] = []
    curved: list[bool] = []
    for seeded in curves:
        use = seeded.curve.uses[face]
        chain = seeded.nodes.tolist() if use.forward else seeded.nodes[::-1].tolist()
        for a, b in itertools.pairwise(chain):
            edges.append((local.setdefault(a, len(local)), local.setdefault(b, len(local))))
            boundary.append(use.role == BOUNDARY)
            curved.append(seeded.is_curved)
    numbers = np.fromiter(local, dtype=np.int64, count=len(local))
    region = Region(
        points=sheet.flat(points[numbers]),
        edges=np.array(edges, dtype=np.int64).reshape(-1, 2),
        is_boundary=np.array(boundary, dtype=bool),
        is_curved=np.array(curved, dtype=bool),
        period=sheet.period,
    )
    return region, numbers


@dataclass(frozen=True, slots=True, eq=False)
class FaceTask:
    """A face to be meshed. name: of the segment, for errors. numbers: of the region's points in the node table.

    kind: "quad" or "tri". growth: of the size per unit of length, None for the usual. frame: (3, 3), user's point =
    frame @ working point, for errors.
    """

    name: str
    sheet: Sheet
    region: Region
    numbers: Indices
    size: float
    kind: str
    growth: float | None
    frame: Array

    def mesh(self, known: Meshes | None = None) -> RegionMesh:
        """In the sheet's plane. known: see planar.mesh_region. MeshError, with the segment and the place in space.

        Where the user asked for an odd number of seeds quads alone are not possible: then quads with few triangles.
        """
        rate = GROWTH if self.growth is None else self.growth
        try:
            try:
                return mesh_region(self.region, self.size, self.kind, rate, known)
            except OddCurveError:
                return mesh_region(self.region, self.size, "mixed", rate, known)
        except RegionError as error:
            place = place_text(self.frame @ self.sheet.lift(error.at[None])[0])
            raise MeshError(f"{self.name}: {error.told(place)}") from error
        except MeshError as error:
            raise MeshError(f"{self.name}: {error.message}") from error

    def lay(self, mesh: RegionMesh, nodes: NodeTable) -> FaceMesh:
        """The face's mesh in space: its inner nodes are added to the table."""
        numbers = np.concatenate([self.numbers, nodes.add(self.sheet.lift(mesh.points[len(self.numbers) :]))])
        return FaceMesh(
            nodes=numbers,
            flat=mesh.points,
            quads=numbers[mesh.quads.reshape(-1, 4)],
            triangles=numbers[mesh.triangles.reshape(-1, 3)],
        )


def mesh_all(tasks: Sequence[FaceTask]) -> Iterator[RegionMesh]:
    """The faces' meshes in their order, in threads where that pays: kernels let go of the interpreter's lock.

    Equal faces, and equal cells of faces, are meshed once. The meshes are the same in any number of threads, and so is
    the error, that of the first face that has one.
    """
    wanted = sum(enclosed_area(task.region) / task.size**2 for task in tasks)
    n_thread = min(len(tasks), os.cpu_count() or 1)
    known: Meshes = {}
    if n_thread < 2 or wanted < WORTH_THREADS:
        yield from (task.mesh(known) for task in tasks)
        return
    with ThreadPoolExecutor(n_thread) as pool:
        yield from pool.map(FaceTask.mesh, tasks, itertools.repeat(known))


def mesh_face(
    name: str,
    face: int,
    sheet: Sheet,
    curves: Sequence[SeededCurve],
    size: float,
    kind: str,
    nodes: NodeTable,
    frame: Array,
    growth: float | None = None,
) -> FaceMesh:
    """Mesh one face and add its inner nodes. name, kind, growth, frame: see FaceTask."""
    task = FaceTask(name, sheet, *face_region(face, sheet, curves, nodes.points), size, kind, growth, frame)
    return task.lay(task.mesh(), nodes)


def curve_middles(topology: Topology, curves: Sequence[SeededCurve]) -> tuple[Indices, Array]:
    """Edges (n, 2) on curves that are not straight, and the points (n, 3) of their curves amid them."""
    edges, places = [np.empty((0, 2), np.int64)], [np.empty((0, 3))]
    for seeded in curves:
        if seeded.is_curved:
            middle = 0.5 * (seeded.parameters[:-1] + seeded.parameters[1:])
            edges.append(np.stack([seeded.nodes[:-1], seeded.nodes[1:]], axis=1))
            places.append(topology.carrier(seeded.curve.carrier).at(middle))
    return np.concatenate(edges), np.concatenate(places)
