"""What lies about a place is found as if the whole mesh were looked at."""

import numpy as np
import pytest
from handmade import grid, model_of, shell_cantilever

from kernel.connect.model import Property
from kernel.edit.edited import Edited
from kernel.edit.surroundings import WIDTHS, kept_edges, shells_about
from kernel.edit.workpiece import Workpiece
from kernel.mesh.mesh import ElementBlock


def workpiece(model):
    edited = Edited.of(model)
    return Workpiece(edited.model, edited.reference)


def crossing_plates():
    """A plate of 100 x 60 in z = 0 (s1), and one that stands on its nodes at y = 30 (s2)."""
    nodes, quads = grid((0, 0, 0), (100, 0, 0), (0, 60, 0), 10, 6)
    upper, standing = grid((0, 30, 0), (100, 0, 0), (0, 0, 20), 10, 2)
    points, place = np.unique(np.vstack([nodes, upper]), axis=0, return_inverse=True)
    properties = [Property(name, "shell", "steel", thickness=2.0) for name in ("s1", "s2")]
    blocks = [
        ElementBlock("s1", "quad4", place.reshape(-1)[quads]),
        ElementBlock("s2", "quad4", place.reshape(-1)[len(nodes) + standing]),
    ]
    return model_of(points, blocks, properties)


def test_the_edges_that_stay_about_a_place_are_those_of_the_whole_mesh():
    work = workpiece(crossing_plates())
    everywhere = kept_edges(work, "s1", np.ones(len(work.nodes), bool))
    y = work.nodes[:, 1]
    expected_rim = 2 * (10 + 6)
    assert len(everywhere) == expected_rim + 10
    assert sum(bool((y[list(pair)] == 30).all()) for pair in everywhere) == 10
    for place in ((33, 27, 0), (2, 2, 0), (50, 30, 0)):
        about = shells_about(work, "s1", np.array(place, float)).nodes(len(work.nodes))
        near = {pair for pair in everywhere if about[list(pair)].all()}
        assert kept_edges(work, "s1", about) == near


@pytest.mark.parametrize("kind", ["quad4", "tri3", "quad8"])
def test_no_element_within_the_widest_patch_is_left_out(kind):
    work = workpiece(shell_cantilever(kind, 100, 60, 2, (40, 24)))
    place = np.array([33.1, 21.7, 0])
    around = shells_about(work, "s1", place)
    middles = np.array([work.nodes[list(corners)].mean(axis=0) for _, _, corners in around.rows])
    assert np.linalg.norm(middles - place, axis=1) == pytest.approx(around.distance)
    (block,) = work.blocks
    corners = block.connectivity[:, : 3 if kind == "tri3" else 4]
    within = np.linalg.norm(work.nodes[corners].mean(axis=1) - place, axis=1) <= max(WIDTHS) * around.size
    assert [element for _, element, _ in around.rows] == np.flatnonzero(within).tolist()
    assert 0 < within.sum() < len(corners) / 4
