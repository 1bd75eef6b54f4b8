"""The model as JSON: everything that a program needs, in numbers that lose nothing."""

import json

import numpy as np
from handmade import cantilever, i_outline

from kernel.deck.deck import format_for


def written(model) -> dict:
    return json.loads(format_for("model.json").write(model))


def test_nodes_and_elements_come_back_to_the_last_bit():
    model = cantilever(i_outline(), 1000.0 / 3.0, 7)
    read = written(model)
    assert (np.array(read["nodes"]) == model.mesh.nodes).all()
    (block,) = read["blocks"]
    assert (np.array(block["connectivity"]) == model.mesh.blocks[0].connectivity).all()
    assert (np.array(block["orientation"]) == model.mesh.blocks[0].orientation).all()


def test_the_section_and_its_material_are_whole():
    model = cantilever(i_outline(), 1000.0, 4)
    read = written(model)
    (element,) = read["properties"]
    assert element["section"]["j"] == model.properties[0].section.j
    assert read["materials"][element["material"]]["density"] > 0
    assert read["units"] == "mm"


def test_the_same_model_gives_the_same_bytes():
    decks = {format_for("model.json").write(cantilever(i_outline(), 1000.0, 4)) for _ in range(2)}
    assert len(decks) == 1
