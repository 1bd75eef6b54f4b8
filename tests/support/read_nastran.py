"""Reads NASTRAN decks with pyNastran and prints what it found as JSON; run in its own environment (numpy < 2).

python read_nastran.py DECK... -> a list with one object a deck
"""

import json
import sys

from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties


def plain(value):
    return None if value is None else float(value)


def element(card):
    found = {"type": card.type, "pid": card.pid, "nodes": [int(n) if n else None for n in card.node_ids]}
    if card.type == "CBAR":
        found["vector"] = [float(x) for x in card.x]
    return found


def prop(card):
    if card.type == "PSHELL":
        return {"type": card.type, "material": card.mid1, "bending": card.mid2, "shear": card.mid3, "t": plain(card.t)}
    if card.type == "PBAR":
        names = ("A", "i1", "i2", "i12", "j", "k1", "k2", "c1", "c2", "d1", "d2", "e1", "e2", "f1", "f2")
        return {"type": card.type, "material": card.mid, **{name: plain(getattr(card, name)) for name in names}}
    return {
        "type": card.type,
        "material": card.mid,
        "integration": card.integ,
        "stress": card.stress,
        "isop": card.isop,
    }


def rbe3(card):
    groups = zip(card.weights, card.comps, card.Gijs)
    weights = {int(n): (float(w), c) for w, c, nodes in groups for n in (nodes if isinstance(nodes, list) else [nodes])}
    return {"dependent": card.refgrid, "components": card.refc, "weights": weights}


def read(path):
    model = BDF(debug=None, log=None)
    model.read_bdf(path, xref=True)  # every id that a card names must be there
    rigid = model.rigid_elements.values()
    mpcs = [card for cards in model.mpcs.values() for card in cards]
    mass, centre, _ = mass_properties(model)
    return {
        "nodes": {nid: node.xyz.tolist() for nid, node in model.nodes.items()},
        "elements": {eid: element(card) for eid, card in model.elements.items()},
        "properties": {pid: prop(card) for pid, card in model.properties.items()},
        "materials": {mid: {"e": m.e, "nu": m.nu, "rho": m.rho} for mid, m in model.materials.items()},
        "rbe2": [
            {"independent": card.gn, "dependent": card.Gmi, "components": card.cm}
            for card in rigid
            if card.type == "RBE2"
        ],
        "rbe3": [rbe3(card) for card in rigid if card.type == "RBE3"],
        "mpc": [
            {
                "nodes": card.node_ids,
                "components": [int(c) for c in card.components],
                "coefficients": [float(c) for c in card.coefficients],
            }
            for card in mpcs
        ],
        "sets": sets(model.case_control_deck),
        "mass": float(mass),
        "centre": centre.tolist(),
        "unread": {name: count for name, count in model.card_count.items() if name in model.reject_count},
    }


def sets(case):
    found = {}
    for key in case.subcases[0].params:
        if key.startswith("SET "):
            found[int(key.split()[1])] = sorted(expanded(case.subcases[0].params[key][0]))
    return found


def expanded(items):
    numbers = []
    for item in items:
        if isinstance(item, str):
            first, last = item.upper().split("THRU")
            numbers += range(int(first), int(last) + 1)
        else:
            numbers.append(int(item))
    return numbers


if __name__ == "__main__":
    print(json.dumps([read(path) for path in sys.argv[1:]]))
