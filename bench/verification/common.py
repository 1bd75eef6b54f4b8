"""What the cases share: the row of a result, models from CSG text, the two solvers, convergence."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

from app.pipeline import Meshed, classify, mesh
from kernel.connect.couplings import nodes_with_rotations
from kernel.connect.model import Model
from kernel.csg.reader import read_model
from kernel.errors import DeckError
from kernel.mesh.options import MeshOptions
from kernel.plan import Override
from verification.loading import Case, ccx, mystran
from verification.solvers import SolverFailed

E, NU, RHO = 210000.0, 0.3, 7.85e-9
G = E / 2 / (1 + NU)
SOLVERS = ("MYSTRAN", "CalculiX")


@dataclass(frozen=True)
class Row:
    """One number against its reference; limit: the share that it may differ by. value None: refused, note says why."""

    case: str
    quantity: str
    representation: str
    solver: str
    value: float | None
    reference: float
    limit: float
    freedoms: int
    note: str = ""

    @property
    def error(self) -> float | None:
        return None if self.value is None else self.value / self.reference - 1

    @property
    def holds(self) -> bool:
        return self.error is None or abs(self.error) <= self.limit


def freedoms(model: Model) -> int:
    """Six at nodes of beams and shells, three at the others."""
    turning = nodes_with_rotations(model.mesh)
    return int(6 * turning.sum() + 3 * (~turning).sum())


@cache
def built(text: str, overrides: tuple[tuple[str, str], ...] = (), **options) -> Meshed:
    """The text through csgmesh; `coupling` apart, options are MeshOptions', sizes as pairs of node and size."""
    coupling = options.pop("coupling", "distributing")
    options["sizes"] = dict(options.get("sizes", ()))
    pinned = {node: Override(kind) for node, kind in overrides}
    meshed = mesh(classify(read_model(text, "case.csg"), overrides=pinned), MeshOptions(**options), coupling=coupling)
    if not meshed.checks.passed:
        raise AssertionError("; ".join(meshed.checks.failures))
    return meshed


def solved(solver: str, model: Model, case: Case, **options):
    return mystran(model, case) if solver == "MYSTRAN" else ccx(model, case, **options)


def rows(row: Row, model: Model, measure: Callable[[str], float], solvers=SOLVERS) -> Iterator[Row]:
    """The row for each solver; a deck that a format refuses is reported as such."""
    for solver in solvers:
        filled = replace(row, solver=solver, freedoms=freedoms(model))
        try:
            yield replace(filled, value=float(measure(solver)))
        except DeckError as error:
            yield replace(filled, note=f"refused: {error}")
        except SolverFailed as error:
            raise AssertionError(f"{row.case}, {row.representation}, {solver}: {error}") from error


def blank(case: str, quantity: str, representation: str, reference: float, limit: float, note: str = "") -> Row:
    return Row(case, quantity, representation, "", None, reference, limit, 0, note)


REENTRANT = 1.09
"""Order in which solid models of right-angled inner edges converge: the stress there is singular with r^-0.4555
(Williams, J. Appl. Mech. 19, 1952), so that the strain energy's error goes with h^1.09."""


def converged(sizes: tuple[float, float], values: tuple[float, float], order: float = REENTRANT) -> float:
    """What the values at two element sizes, the coarser first, tend to (Richardson)."""
    ratio = (sizes[0] / sizes[1]) ** order
    return values[1] + (values[1] - values[0]) / (ratio - 1)
