"""Squared geometries: what is combined of them without a grid is what the grid would have made of it."""

from __future__ import annotations

import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon, box

from kernel.idealise.gridded import squared

GRID = 1e-3


@st.composite
def rectangle(draw) -> Polygon:
    """A rectangle on a coarse lattice, its edges off it by less than half a grid."""
    left, low = draw(st.integers(0, 12)), draw(st.integers(0, 12))
    width, height = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    off = [draw(st.floats(-0.4, 0.4)) * GRID for _ in range(4)]
    return box(left + off[0], low + off[1], left + width + off[2], low + height + off[3])


@given(st.lists(rectangle(), min_size=2, max_size=8))
def test_a_union_of_squared_rectangles_is_that_on_the_grid(rectangles):
    (on_grid,) = squared([rectangles], GRID)
    found, wanted = shapely.union_all(on_grid), shapely.union_all(rectangles, grid_size=GRID)
    assert found.is_valid
    assert len(shapely.get_parts(found)) == len(shapely.get_parts(wanted))
    assert found.hausdorff_distance(wanted) < 1e-6 * GRID


@given(rectangle(), rectangle(), st.integers(-3, 25))
def test_layers_come_back_as_they_were_given(one, other, height):
    line = LineString([(-1, height), (30, height)])
    layers = [[one, other], [], [line]]
    on_grid = squared(layers, GRID)
    assert [len(layer) for layer in on_grid] == [2, 0, 1]
    assert on_grid[2][0].hausdorff_distance(line) < 1e-6 * GRID
    for before, after in zip(layers[0], on_grid[0]):
        assert before.hausdorff_distance(after) < GRID


def test_holes_count_as_edges_do():
    plate = Polygon([(0, 0), (9, 0), (9, 9), (0, 9)], [[(2, 2), (2, 4), (4, 4), (4, 2)]])
    ((found,),) = squared([[plate]], GRID)
    assert found.hausdorff_distance(plate) < 1e-6 * GRID
    assert len(found.interiors) == 1
    drilled = box(0, 0, 9, 9).difference(shapely.Point(4, 4).buffer(1))
    assert squared([[plate], [drilled]], GRID) is None


def test_edges_askew_and_slots_that_the_grid_closes_are_left_to_it():
    assert squared([[Polygon([(0, 0), (5, 0), (0, 5)])]], GRID) is None
    assert squared([[box(0, 0, 5, 0.3 * GRID)]], GRID) is None
    slotted = box(0, 0, 5, 5).difference(box(2, 1, 2 + 0.3 * GRID, 5))
    assert squared([[slotted]], GRID) is None
