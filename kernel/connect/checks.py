"""The checks that every model passes before it is written: what the report's proof stands on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import coincident_nodes, connected_components, coupling_nodes, edge_cracks, loose_arms
from kernel.connect.couplings import nodes_with_rotations
from kernel.connect.equations import rigid_links_error, rigid_motion_error
from kernel.connect.mass import Moments, block_moments, total
from kernel.connect.model import Coupling, Model, Mpc, Rbe2
from kernel.connect.reference import Reference, reference_of
from kernel.units import VERTEX_TOLERANCE

if TYPE_CHECKING:
    from kernel.idealise.ledger_row import LedgerRow
    from kernel.mesh.assembly import Assembly
    from kernel.solid.evaluate import Evaluated

RIGID_MOTION_TOLERANCE = 1e-9
"""Residual of a coupling under unit rigid motions of the model (see equations.rigid_motion_error)."""

MASS_TOLERANCE = 5e-3
"""The model's mass less the ledger's corners agrees with the solid's within this."""


@dataclass(frozen=True, slots=True, eq=False)
class Checks:
    """components, solid_components: connected pieces of the model (couplings counted) and of the CSG solid.

    free_nodes: nodes of no element and no coupling. coincident_nodes: pairs nearer than the vertex tolerance that no
    coupling ties. coupling_error: worst residual under the six rigid motions. doubly_dependent: freedoms that depend
    twice. chained: freedoms that depend on something and are independent elsewhere.
    loose_arms: nodes of edges that should hang by rigid arms and do not.
    cracks: mesh edges on shared curves that are not used as often as their faces say, with edges used once elsewhere.
    masses in the unit set's mass; centres (3,) and inertias (3, 3) in the user's frame, about each one's own centre.
    mass_error: model's mass over the solid's, less 1; accounted_mass_error: the same after the ledger's corners are
    taken from the model. Of volumes, where no material weighs anything.
    ledger: double-counted corners (volumes); ledger_mass: their mass, 0 where densities are scaled to make up for it.
    failures: one line for each check that does not hold.
    """

    components: int
    solid_components: int
    free_nodes: int
    coincident_nodes: int
    coupling_error: float
    doubly_dependent: int
    chained: int
    cracks: int
    loose_arms: int
    solid_mass: float
    model_mass: float
    ledger_mass: float
    solid_centre: NDArray[np.float64]
    model_centre: NDArray[np.float64]
    solid_inertia: NDArray[np.float64]
    model_inertia: NDArray[np.float64]
    mass_error: float
    accounted_mass_error: float
    ledger: tuple[LedgerRow, ...]
    failures: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """No check failed."""
        return not self.failures

    def to_json(self) -> dict[str, Any]:
        """For reports and `--json`."""
        return {
            "passed": self.passed,
            "failures": list(self.failures),
            "components": self.components,
            "solid_components": self.solid_components,
            "free_nodes": self.free_nodes,
            "coincident_nodes": self.coincident_nodes,
            "coupling_error": self.coupling_error,
            "doubly_dependent": self.doubly_dependent,
            "chained": self.chained,
            "cracks": self.cracks,
            "loose_arms": self.loose_arms,
            "mass": {
                "solid": self.solid_mass,
                "model": self.model_mass,
                "error": self.mass_error,
                "ledger": self.ledger_mass,
                "accounted_error": self.accounted_mass_error,
            },
            "centre": {"solid": self.solid_centre.tolist(), "model": self.model_centre.tolist()},
            "inertia": {"solid": self.solid_inertia.tolist(), "model": self.model_inertia.tolist()},
            "ledger": [
                {"segments": list(row.segments), "cause": row.cause, "volume": row.volume, "kind": row.kind}
                for row in self.ledger
                if row.volume
            ],
        }


def check_model(model: Model, assembly: Assembly, evaluated: Evaluated) -> Checks:
    """All checks of the model against itself, its assembly and the solid that it stands for."""
    return check_against(model, reference_of(assembly, evaluated))


def check_against(model: Model, reference: Reference) -> Checks:
    """All checks of the model against itself and what it was made to be."""
    nodes = model.mesh.nodes
    size = reference.size
    centre = (nodes.min(axis=0) + nodes.max(axis=0)) / 2
    links = [coupling for coupling in model.couplings if isinstance(coupling, Rbe2)]
    errors = [
        rigid_links_error(links, nodes, centre, size),
        *(rigid_motion_error(other, nodes, centre, size) for other in model.couplings if not isinstance(other, Rbe2)),
    ]
    weighty = _with_weight(model)
    solid, meshed, density = _masses(weighty, reference.solid)
    corners = 0.0 if _is_weighed(model) else sum(row.volume for row in reference.ledger) * density
    weight = 1.0 if weighty is model else 0.0
    doubly, chained = dependence(model.couplings, nodes_with_rotations(model.mesh))
    checks = Checks(
        components=connected_components(model),
        solid_components=reference.pieces,
        free_nodes=_free_nodes(model),
        coincident_nodes=coincident_nodes(model, VERTEX_TOLERANCE * size, reference.joined),
        coupling_error=max(errors),
        doubly_dependent=doubly,
        chained=chained,
        cracks=edge_cracks(model.mesh, reference.curve_uses),
        loose_arms=loose_arms(model, reference.arms),
        solid_mass=weight * solid.mass,
        model_mass=weight * meshed.mass,
        ledger_mass=weight * corners,
        solid_centre=solid.centre,
        model_centre=meshed.centre,
        solid_inertia=weight * solid.inertia,
        model_inertia=weight * meshed.inertia,
        mass_error=meshed.mass / solid.mass - 1,
        accounted_mass_error=(meshed.mass - corners) / solid.mass - 1,
        ledger=reference.ledger,
        failures=(),
    )
    return _with_failures(checks, reference)


def dependence(couplings: tuple[Coupling, ...], has_rotations: NDArray[np.bool_]) -> tuple[int, int]:
    """How many freedoms depend twice, and how many are both dependent and independent."""
    dependent: dict[tuple[int, int], int] = {}
    independent: set[tuple[int, int]] = set()
    for coupling in couplings:
        if isinstance(coupling, Rbe2):
            freedoms = [(int(node), int(c)) for node in coupling.dependent for c in coupling.components]
            independent.update(
                (coupling.independent, c) for c in range(1, 7 if has_rotations[coupling.independent] else 4)
            )
        elif isinstance(coupling, Mpc):
            freedoms = [(int(coupling.nodes[0]), int(coupling.components[0]))]
            independent.update(zip(map(int, coupling.nodes[1:]), map(int, coupling.components[1:])))
        else:
            freedoms = [(coupling.dependent, int(c)) for c in coupling.components]
            independent.update((int(n), int(c)) for n in coupling.independent for c in coupling.independent_components)
        for freedom in freedoms:
            dependent[freedom] = dependent.get(freedom, 0) + 1
    return sum(count > 1 for count in dependent.values()), len(independent & set(dependent))


def _masses(model: Model, volume: Moments) -> tuple[Moments, Moments, float]:
    """Of the solid, of the model, and the solid's density (the mean over the segments where materials differ)."""
    elements = {element.segment: element for element in model.properties}
    nodes = model.mesh.nodes
    parts = []
    for block in model.mesh.blocks:
        element = elements[block.segment]
        parts.append(block_moments(block, nodes, element, model.materials[element.material].density))
    meshed = total(parts)
    densities = {material.density for material in model.materials.values()}
    if len(densities) == 1:
        density = densities.pop()
    else:
        bare = 0.0
        for block in model.mesh.blocks:
            element = elements[block.segment]
            bare += block_moments(block, nodes, element, 1 / element.density_factor).mass
        density = meshed.mass / bare
    return Moments(volume.mass * density, volume.centre, volume.second * density), meshed, density


def _with_weight(model: Model) -> Model:
    """The model itself; where no material in it weighs anything, with a density of 1 to measure its volumes by."""
    if any(model.materials[element.material].density > 0 for element in model.properties):
        return model
    return replace(model, materials={name: replace(m, density=1.0) for name, m in model.materials.items()})


def _is_weighed(model: Model) -> bool:
    """Densities are scaled, so that no corner weighs twice."""
    return any(element.density_factor != 1 for element in model.properties)


def _free_nodes(model: Model) -> int:
    used = np.zeros(model.mesh.n_node, dtype=bool)
    for block in model.mesh.blocks:
        used[block.connectivity.ravel()] = True
    for coupling in model.couplings:
        used[coupling_nodes(coupling)] = True
    return int((~used).sum())


def _with_failures(checks: Checks, reference: Reference) -> Checks:
    expected = checks.solid_components
    tests = (
        (
            checks.components == expected,
            f"the model is in {checks.components} pieces, expected {expected} as {reference.pieces_of}",
        ),
        (checks.free_nodes == 0, f"{checks.free_nodes} nodes belong to nothing"),
        (
            checks.coincident_nodes == 0 or reference.may_coincide,
            f"{checks.coincident_nodes} pairs of nodes coincide and are not tied",
        ),
        (
            checks.coupling_error <= RIGID_MOTION_TOLERANCE,
            f"a coupling resists a rigid motion by {checks.coupling_error:.1e}, limit {RIGID_MOTION_TOLERANCE:g}",
        ),
        (checks.doubly_dependent == 0, f"{checks.doubly_dependent} freedoms depend on two couplings"),
        (checks.chained == 0, f"{checks.chained} dependent freedoms are independent in another coupling"),
        (checks.cracks == 0, f"{checks.cracks} mesh edges on curves are not used as often as their faces say"),
        (checks.loose_arms == 0, f"{checks.loose_arms} nodes of edges that hang by rigid arms are not held by them"),
        (
            abs(checks.accounted_mass_error) <= MASS_TOLERANCE,
            f"the mass differs from the solid's by {checks.accounted_mass_error:+.2%} beside the ledger's corners",
        ),
        *((False, f"{name} {misfit}") for name, misfit in reference.misfits.items()),
    )
    return replace(checks, failures=tuple(text for holds, text in tests if not holds))
