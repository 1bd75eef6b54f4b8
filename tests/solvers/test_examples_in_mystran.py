"""Every example, from its text to a deck that MYSTRAN solves under its own weight."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from verification.loading import dependent_nodes
from verification.solvers import run_mystran

from app.pipeline import Meshed, classify, mesh, read
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

EXAMPLES = Path(__file__).parents[2] / "examples"
HELD = {"table": 2, "pipe": 2, "pipe_with_holes": 2}
"""Along which axis (x unless given) the lowest nodes are held."""

pytestmark = pytest.mark.solver


@cache
def meshed(file: str) -> Meshed:
    return mesh(classify(read(str(EXAMPLES / file))))


def lowest_nodes(model, axis: int) -> list[int]:
    along = model.mesh.nodes[:, axis]
    found = np.flatnonzero(along <= along.min() + 1e-6 * np.ptp(model.mesh.nodes, axis=0).max())
    return sorted(set(found.tolist()) - dependent_nodes(model))


def solve_under_weight(model, held, folder):
    solved = run_mystran(nastran_self_weight(model, held), folder, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    return solved


@pytest.mark.parametrize("language", ["csg", "padl.csg"])
@pytest.mark.parametrize("name", ["plate_with_holes", "i_beam", "pipe", "pipe_with_holes", "bracket", "table"])
def test_mystran_carries_the_weight_of_the_example(name, language, tmp_path):
    result = meshed(f"{name}.{language}")
    model = result.model
    assert result.checks.passed, result.checks.failures
    solved = solve_under_weight(model, lowest_nodes(model, HELD.get(name, 0)), tmp_path)
    weight = result.checks.model_mass * 9806.65
    assert solved.reactions[:, 2].sum() == pytest.approx(weight, rel=2e-4)
    assert np.abs(solved.reactions[:, :2].sum(axis=0)).max() < 1e-4 * weight
    assert 0 < np.abs(solved.displacements[:, :3]).max() < 1e-2 * np.ptp(model.mesh.nodes, axis=0).max()


@pytest.mark.parametrize("coupling", ["distributing", "rigid", "work"])
def test_the_table_stands_on_any_coupling(coupling, tmp_path):
    classified = meshed("table.csg").classified
    result = mesh(classified, MeshOptions(), coupling=coupling)
    assert result.checks.passed, result.checks.failures
    solved = solve_under_weight(result.model, lowest_nodes(result.model, 2), tmp_path)
    assert solved.reactions[:, 2].sum() == pytest.approx(result.checks.model_mass * 9806.65, rel=2e-4)


def test_a_coupling_by_joint_holds_that_joint_alone(tmp_path):
    """One leg of four rigid: the middle of the top rises by a quarter of what four rigid legs make it."""
    classified = meshed("table.csg").classified
    sunk = []
    for number, choice in enumerate(({}, {"j1": "rigid"}, {joint.id: "rigid" for joint in classified.joints})):
        model = mesh(classified, MeshOptions(size=60.0), joint_couplings=choice).model
        folder = tmp_path / str(number)
        folder.mkdir()
        nodes = model.mesh.nodes
        middle = np.argmin(np.linalg.norm(nodes - [*nodes.mean(axis=0)[:2], nodes[:, 2].max()], axis=1))
        sunk.append(-solve_under_weight(model, lowest_nodes(model, 2), folder).displacements[middle, 2])
    averaged, one_rigid, all_rigid = sunk
    assert all_rigid < one_rigid < averaged
    assert averaged - one_rigid == pytest.approx((averaged - all_rigid) / 4, rel=0.1)


def test_the_table_of_bricks_runs_too(tmp_path):
    csg = read(str(EXAMPLES / "table.csg"))
    bricks = {segment.node: Override("brick") for segment in meshed("table.csg").classified.partition.segments}
    result = mesh(classify(csg, overrides=bricks), MeshOptions(size=60.0))
    assert result.checks.passed, result.checks.failures
    solved = solve_under_weight(result.model, lowest_nodes(result.model, 2), tmp_path)
    assert solved.reactions[:, 2].sum() == pytest.approx(result.checks.model_mass * 9806.65, rel=2e-4)
