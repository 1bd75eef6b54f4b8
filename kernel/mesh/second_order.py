"""Second order for the whole assembly: mid-side nodes on the true curves and surfaces, and in the ties."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.implicit import project
from kernel.idealise.parts import Parts
from kernel.idealise.sheets import CylinderSheet
from kernel.mesh.assembly import Tie
from kernel.mesh.bricks import BrickMesh
from kernel.mesh.faces import FaceMesh, SeededCurve, curve_middles
from kernel.mesh.mesh import Mesh
from kernel.mesh.order import curved, middle_nodes, places_on

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Edge = tuple[int, int]
Among = Callable[[Sequence[int]], list[Edge]]
"""The edges of the mesh that have both ends among some nodes."""


def raise_order(
    mesh: Mesh,
    ties: Sequence[Tie],
    parts: Parts,
    curves: Sequence[SeededCurve],
    faces: dict[str, FaceMesh],
    bricks: dict[str, BrickMesh],
    kinds: Collection[str] | None = None,
) -> tuple[Mesh, tuple[Tie, ...], int]:
    """(mesh of second order, ties with mid-side nodes, number of mid-side nodes drawn back from their surface).

    kinds: raise elements of these kinds only, None for all.
    """
    edges: list[Indices] = [np.empty((0, 2), np.int64)]
    places: list[Array] = [np.empty((0, 3))]
    for found in (
        curve_middles(parts.topology, curves),
        *((brick.edges, brick.middles) for brick in bricks.values()),
        *(_cylinder_middles(parts, name, face, mesh.nodes) for name, face in faces.items()),
    ):
        edges.append(found[0])
        places.append(found[1])
    raised, drawn = curved(mesh, places_on(np.concatenate(edges), np.concatenate(places)), kinds)
    return raised, tuple(_tied(ties, raised)), drawn


def _cylinder_middles(parts: Parts, name: str, face: FaceMesh, points: Array) -> tuple[Indices, Array]:
    """All edges of a cylinder-plate, their middles brought onto its mid-cylinder; none of a plate."""
    sheet = parts.walls[name].sheet
    if not isinstance(sheet, CylinderSheet):
        return np.empty((0, 2), np.int64), np.empty((0, 3))
    edges = np.concatenate(
        [
            np.stack([elements[:, a], elements[:, (a + 1) % elements.shape[1]]], axis=1)
            for elements in (face.quads, face.triangles)
            for a in range(elements.shape[1])
        ]
    )
    return edges, project(points[edges].mean(axis=1), (sheet.surface,))


# ---------------------------------------------------------------- ties


def _tied(ties: Sequence[Tie], mesh: Mesh) -> list[Tie]:
    middles = middle_nodes(mesh)
    of_node: dict[int, list[Edge]] = {}
    for edge in middles:
        for node in edge:
            of_node.setdefault(node, []).append(edge)

    def among(nodes: Sequence[int]) -> list[Edge]:
        chosen = set(nodes)
        return sorted({edge for node in nodes for edge in of_node.get(node, []) if chosen.issuperset(edge)})

    result: list[Tie] = []
    for _, group in itertools.groupby(ties, key=lambda tie: (tie.kind, tie.joint.id if tie.joint else "")):
        of_joint = list(group)
        result += _with_middles(of_joint, among, middles)
    return result


def _with_middles(ties: list[Tie], among: Among, middles: dict[Edge, int]) -> list[Tie]:
    """The ties of one kind and joint, with what holds the mid-side nodes between their dependent nodes."""
    kind = ties[0].kind
    if kind == "rigid" and len(ties) == 1 and len(ties[0].dependent) > 1:
        more = [middles[edge] for edge in among(ties[0].dependent.tolist())]
        return [replace(ties[0], dependent=np.concatenate([ties[0].dependent, np.array(more, dtype=np.int64)]))]
    if kind in ("rigid", "rigid_pairs"):
        follows = {
            int(d): int(i)
            for tie in ties
            for d, i in zip(tie.dependent, np.broadcast_to(tie.independent, tie.dependent.shape))
        }
        pairs = []
        for a, b in among(list(follows)):
            first, second = sorted((follows[a], follows[b]))
            if (first, second) in middles:
                pairs.append((middles[(a, b)], middles[(first, second)]))
        if kind == "rigid":
            return [*ties, *(_pair(ties[0], d, i) for d, i in pairs)]
        dependent, independent = (np.array(side, dtype=np.int64) for side in (zip(*pairs) if pairs else ((), ())))
        tie = ties[0]
        return [
            replace(
                tie,
                dependent=np.concatenate([tie.dependent, dependent]),
                independent=np.concatenate([tie.independent, independent]),
            ),
            *ties[1:],
        ]
    if kind == "interpolated":
        return [_interpolated_middles(tie, among, middles) for tie in ties]
    held = {int(tie.dependent[0]): tie for tie in ties}
    return [*ties, *(_average_between(held[a], held[b], (a, b), among, middles) for a, b in among(list(held)))]


def _pair(tie: Tie, dependent: int, independent: int) -> Tie:
    return replace(tie, dependent=np.array([dependent]), independent=np.array([independent]))


def _mean(first: tuple[Indices, Array], second: tuple[Indices, Array]) -> tuple[Indices, Array]:
    """Half of two weighted sums of nodes."""
    nodes = np.unique(np.concatenate([first[0], second[0]]))
    weights = np.zeros(len(nodes))
    for part, share in (first, second):
        np.add.at(weights, np.searchsorted(nodes, part), 0.5 * share)
    return nodes, weights


def _interpolated_middles(tie: Tie, among: Among, middles: dict[Edge, int]) -> Tie:
    place = {int(node): row for row, node in enumerate(tie.dependent)}
    dependent, hosts, weights = [], [], []
    for a, b in among(list(place)):
        nodes, shares = _mean(
            (tie.hosts[place[a]], tie.host_weights[place[a]]), (tie.hosts[place[b]], tie.host_weights[place[b]])
        )
        dependent.append(middles[(a, b)])
        hosts.append(nodes)
        weights.append(shares)
    return replace(
        tie,
        dependent=np.concatenate([tie.dependent, np.array(dependent, dtype=np.int64)]),
        hosts=(*tie.hosts, *hosts),
        host_weights=(*tie.host_weights, *weights),
    )


def _average_between(first: Tie, second: Tie, edge: Edge, among: Among, middles: dict[Edge, int]) -> Tie:
    """The edge's mid-side node on the average of both patches, their own mid-side nodes among them.

    One of these may lie where it does; were it left out, nothing would hold the two together.
    """
    nodes, weights = _mean((first.independent, first.weights), (second.independent, second.weights))
    between = among(nodes.tolist())
    more = np.array([middles[pair] for pair in between], dtype=np.int64)
    ends = np.searchsorted(nodes, np.array(between, dtype=np.int64).reshape(-1, 2))
    of_all = np.concatenate([weights, weights[ends].mean(axis=1)])
    of_all *= weights.sum() / of_all.sum()
    return replace(
        first, dependent=np.array([middles[edge]]), independent=np.concatenate([nodes, more]), weights=of_all
    )
