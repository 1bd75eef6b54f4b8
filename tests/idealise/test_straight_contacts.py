"""Contacts of flat walls along straight lines: of all at once, they are what each has by itself."""

from __future__ import annotations

import numpy as np
import pytest
from solids import cube, placed, turned, union

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.idealise.crossings import FLAT_OVERLAP, Crossing, reach_of, with_longer
from kernel.idealise.joint_curves import find_crossings
from kernel.idealise.straight_contacts import Side, straight_contacts
from kernel.idealise.topology import Topology
from kernel.idealise.walls import make_wall
from kernel.units import VERTEX_TOLERANCE

ASKEW = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
ASKEW *= np.sign(np.linalg.det(ASKEW))

CORNER = union(cube(300, 200, 8), cube(8, 200, 150, (0, 0, 0)), cube(300, 8, 150, (0, 0, 0)))
EGG_CRATE = union(
    cube(400, 400, 6), *(cube(6, 400, 90, (at, 0, 6)) for at in (50, 200, 340)), cube(400, 6, 90, (0, 150, 6))
)
BROKEN_WEB = union(cube(400, 200, 10), cube(120, 8, 90, (0, 100, 10)), cube(150, 8, 90, (220, 100, 10)))
LEANING = union(cube(300, 200, 10), cube(220, 8, 120, (30, 100, 4), turned("x", 25)))


@pytest.mark.parametrize("turn", [None, ASKEW], ids=["straight", "turned"])
@pytest.mark.parametrize("text", [CORNER, EGG_CRATE, BROKEN_WEB, LEANING], ids=["corner", "crate", "web", "leaning"])
def test_of_all_at_once_they_are_what_each_wall_has_by_itself(text, turn):
    found = classify(read_model(text if turn is None else placed(text, (31.7, -23.1, 11.3), turn), "walls"))
    size = found.evaluated.size
    topology = Topology(VERTEX_TOLERANCE * size, size)
    walls = [make_wall(topology, number, one) for number, one in enumerate(found.partition.segments)]
    crossings = find_crossings(topology, walls, found.joints)
    assert len(crossings) > 1 or len(walls) == 2
    sides, alone = [], []
    for crossing in crossings:
        for wall in crossing.walls:
            sides.append(Side(topology.carrier(crossing.carrier), wall, crossing.other(wall)))
            alone.append(reach_of(topology, Crossing(crossing.walls, crossing.carrier, {}), wall))
    margin = FLAT_OVERLAP * topology.tolerance
    touching, within = straight_contacts(topology, sides, margin), straight_contacts(topology, sides, -margin)
    assert any(alone)
    together = [
        with_longer(topology, one, other, None) if one else [] for one, other in zip(touching, within, strict=True)
    ]
    assert together == alone


def test_no_walls_have_no_contacts():
    assert straight_contacts(Topology(1e-6, 1.0), [], 0.0) == []
