"""Faces meshed on the shared curves: a node is a vertex, a place on a curve, or inside one face."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.carriers import is_curved
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.mesh.line import divisions, inner_points
from kernel.mesh.nodes import NodeTable
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class SeededCurve:
    """A curve and its nodes (n,), ends included, from its first vertex to its second."""

    curve: Curve
    nodes: Indices
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


def seed_curves(
    topology: Topology, curves: Sequence[Curve], sizes: dict[int, float], nodes: NodeTable
) -> list[SeededCurve]:
    """Divide every curve once, by the smallest size of the faces that use it. sizes: by face."""
    numbers: dict[int, int] = {}
    for curve in curves:
        for vertex in curve.vertices:
            if vertex not in numbers:
                numbers[vertex] = int(nodes.add(topology.vertices.points[vertex])[0])
    seeded = []
    for curve in curves:
        carrier = topology.carrier(curve.carrier)
        count = divisions(carrier, curve.length, min(sizes[face] for face in curve.uses))
        inner = nodes.add(inner_points(carrier, curve.start, curve.end, count))
        first, last = (numbers[vertex] for vertex in curve.vertices)
        seeded.append(SeededCurve(curve, np.concatenate([[first], inner, [last]]), is_curved(carrier)))
    return seeded


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


def mesh_face(
    name: str, face: int, sheet: Sheet, curves: Sequence[SeededCurve], size: float, kind: str, nodes: NodeTable
) -> FaceMesh:
    """Mesh one face and add its inner nodes. name: of the segment, for errors. kind: "quad" or "tri"."""
    region, numbers = face_region(face, sheet, curves, nodes.points)
    try:
        mesh = mesh_region(region, size, kind)
    except MeshError as error:
        raise MeshError(f"{name}: {error.message}") from error
    numbers = np.concatenate([numbers, nodes.add(sheet.lift(mesh.points[len(numbers) :]))])
    return FaceMesh(
        nodes=numbers,
        flat=mesh.points,
        quads=numbers[mesh.quads.reshape(-1, 4)],
        triangles=numbers[mesh.triangles.reshape(-1, 3)],
    )


def curve_middles(topology: Topology, curves: Sequence[SeededCurve]) -> tuple[Indices, Array]:
    """Edges (n, 2) on curves that are not straight, and the points (n, 3) of their curves amid them."""
    edges, places = [np.empty((0, 2), np.int64)], [np.empty((0, 3))]
    for seeded in curves:
        if seeded.is_curved:
            count = len(seeded.nodes) - 1
            share = (np.arange(count) + 0.5) / count
            curve = seeded.curve
            edges.append(np.stack([seeded.nodes[:-1], seeded.nodes[1:]], axis=1))
            places.append(topology.carrier(curve.carrier).at(curve.start + share * curve.length))
    return np.concatenate(edges), np.concatenate(places)
