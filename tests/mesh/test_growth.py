"""Growth of the size away from small elements, and elements round circles."""

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit

from kernel.errors import OptionError

DRILLED = """
PLATE = BLO(200, 120, 6)
HOLE1 = CYL(R=12, H=10) AT (MOVX=60, MOVY=60, MOVZ=-2)
HOLE2 = CYL(R=3, H=10) AT (MOVX=140, MOVY=60, MOVZ=-2)
DRILLED = PLATE DIF (HOLE1 UN HOLE2)
"""

ANGLE = "BASE = BLO(160, 100, 10)\nWALL = BLO(10, 100, 140)\nANGLE = BASE UN WALL\n"


def neighbours(assembly) -> np.ndarray:
    """(n, 2) lengths of edges of curves that meet at a node of two edges."""
    nodes, edges = assembly.mesh.nodes, assembly.curve_uses[:, :2]
    length = np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1)
    at: dict[int, list[float]] = {}
    for (a, b), own in zip(edges.tolist(), length.tolist()):
        at.setdefault(a, []).append(own)
        at.setdefault(b, []).append(own)
    return np.array([pair for pair in at.values() if len(pair) == 2])


ROUNDING = 1.15
"""A curve is divided in an even number: its elements are this much longer or shorter than their size at most."""


@pytest.mark.parametrize("growth", [1.1, 1.25, 1.6])
def test_elements_along_curves_grow_by_no_more_than_asked(growth):
    assembly, _ = assembled(DRILLED, size=25.0, growth=growth, seeds={"0,60,3": 80})
    assert audit(assembly) == WHOLE
    pairs = neighbours(assembly)
    assert (pairs.max(axis=1) / pairs.min(axis=1)).max() <= growth * ROUNDING
    other, _ = assembled(DRILLED, size=25.0, growth=growth + 0.5, seeds={"0,60,3": 80})
    assert other.mesh.n_node < assembly.mesh.n_node


def test_small_seeds_make_themselves_felt_over_a_joint_in_the_other_face():
    coarse, _ = assembled(ANGLE, size=30.0)
    graded, evaluated = assembled(ANGLE, size=30.0, growth=1.2, seeds={"160,50,5": 100})
    assert audit(graded) == WHOLE
    nodes = graded.mesh.nodes @ evaluated.frame.T
    edges = graded.curve_uses[:, :2]
    joint = edges[
        (np.abs(nodes[:, 0] - 5) < 1e-6)[edges].all(axis=1) & (np.abs(nodes[:, 2] - 5) < 1e-6)[edges].all(axis=1)
    ]
    assert np.linalg.norm(nodes[joint[:, 0]] - nodes[joint[:, 1]], axis=1).max() < 30
    assert graded.mesh.n_node > 10 * coarse.mesh.n_node


@pytest.mark.parametrize("per_circle", [4, 8, 30, 64])
def test_every_circle_has_at_least_as_many_elements_as_asked(per_circle):
    assembly, evaluated = assembled(DRILLED, size=15.0, per_circle=per_circle)
    assert audit(assembly) == WHOLE
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    for centre, radius in (((60, 60), 12), ((140, 60), 3)):
        on_it = np.abs(np.hypot(*(nodes[:, :2] - centre).T) - radius) < 1e-6
        assert per_circle <= on_it.sum() <= max(per_circle + 2, 2 * np.pi * radius / 15 * 2 + 2)


@pytest.mark.parametrize("per_circle", [12, 24, 48])
def test_a_pipe_has_as_many_round_it(per_circle):
    pipe = "A = CYL(R=50, H=300) DIF CYL(R=48, H=302) AT (MOVZ=-1)\n"
    assembly, evaluated = assembled(pipe, size=100.0, per_circle=per_circle)
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    assert (np.abs(nodes[:, 2]) < 1e-6).sum() == per_circle


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"growth": 1.0}, "growth is 1, expected a ratio above 1, such as 1.2"),
        ({"growth": float("nan")}, "growth is nan"),
        ({"per_circle": 3}, "per_circle is 3, expected a whole number from 4 to"),
        ({"per_circle": 10**7}, "per_circle is 10000000"),
    ],
)
def test_what_makes_no_sense_is_refused(options, complaint):
    with pytest.raises(OptionError, match=complaint):
        assembled(DRILLED, **options)


def test_growth_asked_of_beams_alone_has_nothing_to_grow_along():
    assembly, _ = assembled("BAR = BLO(600, 20, 20)\n", size=30.0, growth=1.2, per_circle=24, layers=2)
    assert [(block.kind, len(block.connectivity)) for block in assembly.mesh.blocks] == [("line2", 20)]
