"""Faces meshed on the shared curves: a node is a vertex, a place on a curve, or inside one face."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.carriers import is_curved
from kernel.idealise.outlines import unwrapped
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.mesh.arms import HungCurve
from kernel.mesh.gaps import SAMPLES_PER_SIZE, SampledCurve, divide, gap_sizes
from kernel.mesh.line import least_divisions
from kernel.mesh.nodes import NodeTable
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region

STRIP = 0.5
"""A line that is beside a narrow strip for most of its length is divided by this share of the size: quads in strips
may be long, and nothing is gained by making them square.
"""

MOST_SAMPLES = 4000
"""Places along one curve at which gaps are measured."""

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


def seed_curves(
    topology: Topology,
    curves: Sequence[Curve],
    sheets: Mapping[int, Sheet],
    sizes: Mapping[int, float],
    nodes: NodeTable,
    hung: Sequence[HungCurve] = (),
) -> list[SeededCurve]:
    """Divide every curve once: by the smallest size of the faces that use it, finer beside narrow gaps in any of them.

    sheets, sizes: by face. hung: curves that are divided as those are from which they hang.
    """
    numbers: dict[int, int] = {}
    for curve in curves:
        for vertex in curve.vertices:
            if vertex not in numbers:
                numbers[vertex] = int(nodes.add(topology.vertices.points[vertex])[0])
    wanted = [min(sizes[face] for face in curve.uses) for curve in curves]
    for one in hung:
        wanted[one.along] = min(wanted[one.along], wanted[one.edge])
    graded = _graded_sizes(topology, curves, sheets, wanted)
    for one in hung:
        one.grade(graded)
    edges = {one.edge: one for one in hung}
    seeded: dict[int, SeededCurve] = {}
    for place, (curve, size, along_curve) in enumerate(zip(curves, wanted, graded)):
        if place in edges:
            continue
        carrier = topology.carrier(curve.carrier)
        samples = np.linspace(0.0, curve.length, len(along_curve))
        inner = curve.start + divide(samples, along_curve, least_divisions(carrier, curve.length, size), is_even=True)
        parameters = np.concatenate([[curve.start], inner, [curve.end]])
        first, last = (numbers[vertex] for vertex in curve.vertices)
        between = nodes.add(carrier.at(inner))
        chain = np.concatenate([[first], between, [last]])
        seeded[place] = SeededCurve(curve, chain, parameters, is_curved(carrier))
    for place, one in edges.items():
        curve, along = curves[place], seeded[one.along]
        parameters, points = one.divided(topology, curve, along.curve, along.parameters)
        first, last = (numbers[vertex] for vertex in curve.vertices)
        chain = np.concatenate([[first], nodes.add(points), [last]])
        seeded[place] = SeededCurve(curve, chain, parameters, is_curved(topology.carrier(curve.carrier)))
    return [seeded[place] for place in range(len(curves))]


def _graded_sizes(
    topology: Topology, curves: Sequence[Curve], sheets: Mapping[int, Sheet], wanted: Sequence[float]
) -> list[Array]:
    """Sizes along each curve, at samples evenly spaced from its start to its end: the least of what its faces ask."""
    by_face: dict[int, list[int]] = {}
    for place, curve in enumerate(curves):
        for face in curve.uses:
            by_face.setdefault(face, []).append(place)
    points = []
    for curve, size in zip(curves, wanted):
        count = int(min(max(np.ceil(SAMPLES_PER_SIZE * curve.length / size), 2 * SAMPLES_PER_SIZE), MOST_SAMPLES))
        points.append(topology.carrier(curve.carrier).at(np.linspace(curve.start, curve.end, count + 1)))
    sizes = [np.full(len(samples), float(size)) for samples, size in zip(points, wanted)]
    for face in sorted(by_face):
        sheet = sheets[face]
        sampled = []
        for place in by_face[face]:
            curve = curves[place]
            use = curve.uses[face]
            flat = unwrapped(sheet, points[place] if use.forward else points[place][::-1])
            first, last = curve.vertices if use.forward else curve.vertices[::-1]
            sampled.append(SampledCurve(flat, first, last, use.role == BOUNDARY, wanted[place]))
        for place, found in zip(by_face[face], gap_sizes(sampled, sheet.turn)):
            ordered = found if curves[place].uses[face].forward else found[::-1]
            if not is_curved(topology.carrier(curves[place].carrier)) and np.median(found) < STRIP * wanted[place]:
                ordered = np.maximum(ordered, STRIP * wanted[place])
            np.minimum(sizes[place], ordered, out=sizes[place])
    return sizes


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
            middle = 0.5 * (seeded.parameters[:-1] + seeded.parameters[1:])
            edges.append(np.stack([seeded.nodes[:-1], seeded.nodes[1:]], axis=1))
            places.append(topology.carrier(seeded.curve.carrier).at(middle))
    return np.concatenate(edges), np.concatenate(places)
