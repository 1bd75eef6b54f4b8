"""Short cuts for tests of assemblies: models as text, assembled, and audited."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from solids import cube, difference, extrusion, placed, rod, tube, turned, union

from kernel.connect.contacts import find_joints
from kernel.csg.reader import read_model
from kernel.mesh.assemble import assemble
from kernel.mesh.assembly import Assembly
from kernel.mesh.options import MeshOptions
from kernel.plan import Override
from kernel.segment.partition import partition
from kernel.solid.evaluate import Evaluated, evaluate
from rules.engine import load_rule_base

__all__ = [
    "Audit",
    "assembled",
    "audit",
    "cube",
    "difference",
    "extrusion",
    "mesh_volume",
    "placed",
    "rod",
    "tube",
    "turned",
    "union",
]

RULES = load_rule_base()
SHELLS = ("quad4", "tri3", "quad8", "tri6")


def assembled(
    text: str, overrides: dict[str, str] | None = None, progress=None, **options
) -> tuple[Assembly, Evaluated]:
    """The assembly of a model, decided by the rule base (and overrides by path)."""
    evaluated = evaluate(read_model(text, "test"))
    pinned = {path: Override(kind) for path, kind in (overrides or {}).items()}
    parts = partition(evaluated, RULES.decide, pinned)
    joints = find_joints(parts.segments, evaluated)
    return assemble(evaluated, parts.segments, joints, MeshOptions(**options), progress), evaluated


@dataclass(frozen=True)
class Audit:
    """components: parts of the model, ties counted. free: nodes of no element. coincident: pairs of nodes at one place
    that no tie holds together.

    cracks: edges of curves that are not used as often as their faces say. loose: shell edges used once that are no
    edges of a curve.
    """

    components: int
    free: int
    coincident: int
    cracks: int
    loose: int


WHOLE = Audit(components=1, free=0, coincident=0, cracks=0, loose=0)


def audit(assembly: Assembly) -> Audit:
    """What the checks of connection ask, counted anew here."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    nodes = assembly.mesh.nodes
    links, used = [], np.zeros(len(nodes), bool)
    uses: dict[tuple[int, int], int] = {}
    for block in assembly.mesh.blocks:
        used[block.connectivity] = True
        links += [(row[0], node) for row in block.connectivity.tolist() for node in row[1:]]
        if block.kind in SHELLS:
            corners = {"quad4": 4, "quad8": 4}.get(block.kind, 3)
            for k in range(corners):
                for pair in np.sort(block.connectivity[:, [k, (k + 1) % corners]], axis=1).tolist():
                    uses[tuple(pair)] = uses.get(tuple(pair), 0) + 1
    for tie in assembly.ties:
        if tie.kind == "rigid_pairs":
            links += list(zip(tie.dependent.tolist(), tie.independent.tolist()))
        elif tie.kind == "interpolated":
            links += [(d, h) for d, hosts in zip(tie.dependent.tolist(), tie.hosts) for h in hosts.tolist()]
        else:
            first = int(tie.independent[0])
            links += [(first, node) for node in (*tie.dependent.tolist(), *tie.independent.tolist())]
    rows = np.array(links).T
    graph = coo_matrix((np.ones(rows.shape[1]), rows), shape=(len(nodes), len(nodes)))
    labels = connected_components(graph, directed=False)[1]
    expected = {tuple(sorted(row[:2])): row[2] for row in assembly.curve_uses.tolist()}
    size = float(np.ptp(nodes, axis=0).max())
    tied = [
        {*tie.dependent.tolist(), *tie.independent.tolist(), *(node for hosts in tie.hosts for node in hosts.tolist())}
        for tie in assembly.ties
    ]
    near = cKDTree(nodes).query_pairs(1e-6 * size)
    return Audit(
        components=len(np.unique(labels[used])),
        free=int((~used).sum()),
        coincident=sum(not any(group.issuperset(pair) for group in tied) for pair in near),
        cracks=sum(uses.get(edge, 0) != count for edge, count in expected.items()),
        loose=sum(count == 1 and edge not in expected for edge, count in uses.items()),
    )


def mesh_volume(assembly: Assembly) -> float:
    """Shells times thickness, beams times section, solids, all of first order."""
    thickness = {segment.id: segment.thickness for segment in assembly.segments}
    total = 0.0
    for block in assembly.mesh.blocks:
        corners = assembly.mesh.nodes[block.connectivity]
        if block.kind == "tri3":
            cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            total += thickness[block.segment] * float(np.linalg.norm(cross, axis=1).sum()) / 2
        elif block.kind == "quad4":  # those on tubes are warped: Gauss points, as many as the model's own mass takes
            places, weights = np.polynomial.legendre.leggauss(3)
            for (xi, eta), (w, v) in zip(itertools.product(places, repeat=2), itertools.product(weights, repeat=2)):
                along = np.array([eta - 1, 1 - eta, 1 + eta, -1 - eta]) / 4
                across = np.array([xi - 1, -1 - xi, 1 + xi, 1 - xi]) / 4
                cross = np.cross(along @ corners, across @ corners)
                total += w * v * thickness[block.segment] * float(np.linalg.norm(cross, axis=1).sum())
        elif block.kind == "line2":
            length = float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).sum())
            total += assembly.sections[block.segment].area * length
        else:
            fans = {
                "hex8": ((0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7)),
                "wedge6": ((0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)),
                "tet4": ((0, 1, 2, 3),),
            }[block.kind]
            for fan in fans:
                p = corners[:, fan]
                total += (
                    float(
                        np.abs(
                            np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0])
                        ).sum()
                    )
                    / 6
                )
    return total
