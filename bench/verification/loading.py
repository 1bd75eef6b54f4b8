"""Consistent nodal forces, supports by place, and the two solvers' decks for one load case or for frequencies."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kernel.connect.couplings import nodes_with_rotations
from kernel.connect.model import Model, Mpc, Rbe2
from kernel.deck import calculix, nastran
from kernel.deck.keywords import real
from kernel.deck.numbers import fixed_field
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.shapes import integration_rule, jacobians, measures
from verification.solvers import Solved, ccx_frequencies, mystran_frequencies, run_calculix, run_mystran

Pick = Callable[[np.ndarray], np.ndarray]
"""From (n, 3) places to (n,) truth."""

_FACE_KINDS = {(3, 1): "tri3", (4, 1): "quad4", (3, 2): "tri6", (4, 2): "quad8"}


@dataclass(frozen=True)
class Case:
    """held: node -> components; forces: node -> (3,) force; moments: node -> (3,) moment."""

    held: dict[int, str]
    forces: dict[int, np.ndarray]
    moments: dict[int, np.ndarray] = field(default_factory=dict)


def nodes_where(model: Model, pick: Pick) -> list[int]:
    return np.flatnonzero(pick(model.mesh.nodes)).tolist()


def at(axis: int, value: float, tolerance: float = 1e-6) -> Pick:
    return lambda places: np.abs(places[:, axis] - value) < tolerance


def dependent_nodes(model: Model) -> set[int]:
    """Nodes that a coupling moves: a support there would contradict it."""
    nodes: set[int] = set()
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            nodes.update(coupling.dependent.tolist())
        else:
            nodes.add(int(coupling.nodes[0]) if isinstance(coupling, Mpc) else coupling.dependent)
    return nodes


def held_at(model: Model, pick: Pick, components: str = "123456") -> dict[int, str]:
    """Supports at the picked nodes, but at those that follow others."""
    bound = dependent_nodes(model)
    return {node: components for node in nodes_where(model, pick) if node not in bound}


def weights(model: Model, pick: Pick) -> dict[int, float]:
    """Area (of solids' faces, shells' edges times thickness, beams' sections) that each picked node stands for.

    A face or edge counts where all its nodes are picked; a beam's node counts with its section; where whole shells
    are picked, they count with their own area.
    """
    chosen = pick(model.mesh.nodes)
    result: dict[int, float] = {}

    def add(kind: str, rows: np.ndarray, factor: float) -> None:
        rule = integration_rule(kind)
        places = model.mesh.nodes[rows]
        density = measures(jacobians(places, rule)) * rule.weights * factor
        for node, value in zip(rows.ravel(), np.einsum("eq,qn->en", density, rule.values).ravel()):
            result[int(node)] = result.get(int(node), 0.0) + float(value)

    for block, element in _elements(model):
        kind = ELEMENT_KINDS[block.kind]
        whole = chosen[block.connectivity].all(axis=1)
        if kind.dimension == 1:
            for node in np.unique(block.connectivity[:, :2][chosen[block.connectivity[:, :2]]]):
                result[int(node)] = element.section.area
        elif kind.dimension == 2 and whole.any():
            add(block.kind, block.connectivity[whole], 1.0)
        else:
            _boundary(block, kind, chosen, element.thickness or 1.0, add)
    return result


def _elements(model: Model):
    by_segment = {element.segment: element for element in model.properties}
    return [(block, by_segment[block.segment]) for block in model.mesh.blocks]


def _boundary(block, kind, chosen, thickness, add) -> None:
    """Edges of shells and outer faces of solids whose nodes are all picked."""
    for loop in kind.edges if kind.dimension == 2 else kind.faces:
        places = list(loop)
        if kind.order == 2:
            ends = loop[1:] if kind.dimension == 2 else loop[1:] + loop[:1]
            places += [kind.n_corner + _edge(kind, pair) for pair in zip(loop, ends, strict=False)]
        rows = block.connectivity[:, places]
        rows = rows[chosen[rows].all(axis=1)]
        if len(rows):
            name = ("line2", "line3")[kind.order - 1] if kind.dimension == 2 else _FACE_KINDS[(len(loop), kind.order)]
            add(name, rows, thickness if kind.dimension == 2 else 1.0)


def _edge(kind, pair) -> int:
    return next(k for k, edge in enumerate(kind.edges) if set(edge) == set(pair))


def spread(model: Model, pick: Pick, force) -> dict[int, np.ndarray]:
    """A total force, shared out by area."""
    share = weights(model, pick)
    total = sum(share.values())
    return {node: np.asarray(force, float) * value / total for node, value in share.items()}


def pressed(model: Model, pick: Pick, pressure: Callable[[np.ndarray], np.ndarray]) -> dict[int, np.ndarray]:
    """A pressure field, (3,) at a place, times the nodes' areas."""
    return {node: pressure(model.mesh.nodes[node]) * value for node, value in weights(model, pick).items()}


def mystran(model: Model, case: Case) -> Solved:
    bulk = [f"SPC1,1,{components},{node + 1}" for node, components in sorted(case.held.items())]
    for card, loads in (("FORCE*", case.forces), ("MOMENT*", case.moments)):
        for node, load in sorted(loads.items()):
            x, y, z = (fixed_field(float(v)) for v in load)
            bulk.append(f"{card:<8}{1:>16}{node + 1:>16}{0:>16}{'1.':>16}\n{'*':<8}{x:>16}{y:>16}{z:>16}")
    control = ["LOAD = 1", "SPC = 1", "DISPLACEMENT = ALL", "SPCFORCES = ALL"]
    with tempfile.TemporaryDirectory() as folder:
        return run_mystran(nastran.assemble_deck(model, control, bulk), Path(folder), model.mesh.n_node)


def _ccx_supports(model: Model, held: dict[int, str]) -> list[str]:
    turning = nodes_with_rotations(model.mesh)
    lines = ["*NSET, NSET=HELD", *(str(node + 1) for node in sorted(held)), "*BOUNDARY"]
    for node, components in sorted(held.items()):
        lines += [f"{node + 1}, {c}" for c in components if turning[node] or c in "123"]
    return lines


def ccx(model: Model, case: Case, *, stress: bool = False) -> Solved:
    lines = [*_ccx_supports(model, case.held), "*STEP", "*STATIC", "*CLOAD"]
    for node, force in sorted(case.forces.items()):
        lines += [f"{node + 1}, {k + 1}, {real(float(v))}" for k, v in enumerate(force) if v]
    for node, moment in sorted(case.moments.items()):
        lines += [f"{node + 1}, {k + 4}, {real(float(v))}" for k, v in enumerate(moment) if v]
    lines += ["*NODE PRINT, NSET=NALL", "U", "*NODE PRINT, NSET=HELD, TOTALS=ONLY", "RF"]
    if stress:
        lines += ["*EL FILE, OUTPUT=2D", "S"]
    with tempfile.TemporaryDirectory() as folder:
        deck = calculix.assemble_deck(model, [*lines, "*END STEP"])
        return run_calculix(deck, Path(folder), model.mesh.n_node)


def frequencies(model: Model, held: dict[int, str], solver: str, count: int = 6) -> np.ndarray:
    """(count,) in hertz, ascending."""
    with tempfile.TemporaryDirectory() as folder:
        if solver == "MYSTRAN":
            bulk = [f"EIGRL,1,,,{count}"]
            bulk += [f"SPC1,1,{components},{node + 1}" for node, components in sorted(held.items())]
            control = ["METHOD = 1", "SPC = 1"]
            return mystran_frequencies(nastran.assemble_deck(model, control, bulk, 103), Path(folder))
        lines = [*_ccx_supports(model, held), "*STEP", "*FREQUENCY", str(count)]
        lines += ["*NODE PRINT, NSET=NALL, TOTALS=ONLY", "RF", "*END STEP"]
        return ccx_frequencies(calculix.assemble_deck(model, lines), Path(folder))
