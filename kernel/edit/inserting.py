"""Adding a node to a mesh where one is wanted: for a support, a load, a place to look at.

In a beam its element is split in two. In a shell the patch about the place is meshed anew (kernel/edit/patch.py); on a
curve the curve's edge is split, in every segment that shares it. A mesh of solids takes no single node: there the
nearest one is moved instead (move_node).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.connect.build import clean_coordinates
from kernel.edit.edited import Edited
from kernel.edit.fitted import Fitted
from kernel.edit.locate import Found, nearest_element, project_on
from kernel.edit.patch import Split, insert_in_patch, surface_of
from kernel.edit.surroundings import kept_edges, shells_about
from kernel.edit.workpiece import Edge, Workpiece
from kernel.errors import MeshError, OptionError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.quality import refuse_inverted
from kernel.mesh.shapes import shape_values
from kernel.places import place_text

Array = NDArray[np.float64]

AT_PLACE = 1e-6
"""A place lies on what is nearer to it than this share of the model's size."""

BULGE = 0.1
"""Chords of elements leave a cylinder by less than this share of the elements' size."""

STAYS = 1e-14
"""A place that moves by no more than this share of the model's size, or of its coordinates, stays where it is."""

TOO_NEAR = 0.05
"""A place nearer to a curve than this share of its edge would leave no room for an element between them."""


def add_node(edited: Edited, at: Array, tolerance: float | None = None) -> Edited:
    """A node at a place on a beam's axis or a shell's mid-surface. tolerance: how far the node may be moved onto it.

    OptionError: the place lies on no beam and no shell (the nearest place is told), or has a node already.
    MeshError: no mesh with a node there would be good enough.
    """
    model = edited.model
    place = np.asarray(at, dtype=np.float64)
    reach = AT_PLACE * edited.reference.size if tolerance is None else tolerance
    distances = np.linalg.norm(model.mesh.nodes - place, axis=1)
    if distances.min() <= AT_PLACE * edited.reference.size:
        raise OptionError(f"there is a node at {place_text(place)} already")
    found = nearest_element(model.mesh, place, (1, 2))
    if found is None:
        raise OptionError("the mesh has no beams and no shells, expected some: in solids move the nearest node instead")
    work = Workpiece(model, edited.reference)
    if ELEMENT_KINDS[work.blocks[found.block].kind].dimension == 1:
        node, told = _in_beam(work, found, place, reach)
    else:
        node, told = _in_shell(work, found, place, reach)
    on = clean_coordinates(work.nodes[node], edited.reference.size)
    changed, reference = work.finished()
    refuse_inverted(changed.mesh)
    return edited.done(changed, reference, f"added a node at {place_text(on)} in {told}")


def _refuse_off(place: Array, on: Array, reach: float, what: str) -> None:
    if np.linalg.norm(place - on) > reach:
        raise OptionError(
            f"{place_text(place)} lies {np.linalg.norm(place - on):.4g} beside {what}, expected a place on it: "
            f"the nearest is {place_text(on)}"
        )


# ---------------------------------------------------------------- beams


def _in_beam(work: Workpiece, found: Found, place: Array, reach: float) -> tuple[int, str]:
    block = work.blocks[found.block]
    _refuse_off(place, found.place, reach, f"the axis of {block.segment}")
    node = int(work.add_nodes(found.place[None])[0])
    _split_line(work, found.block, found.element, node, float(found.local[0]))
    return node, block.segment


def _split_line(work: Workpiece, index: int, element: int, node: int, local: float) -> None:
    """Two elements in the place of one; local: of the node, from -1 to 1."""
    block = work.blocks[index]
    row = block.connectivity[element]
    if ELEMENT_KINDS[block.kind].order == 1:
        rows = [[row[0], node], [node, row[1]]]
    else:
        if int(row[2]) in work.held:
            raise MeshError(f"the mid-side node of {block.segment} beside the place is held by a coupling")
        halves = np.array([[(local - 1) / 2], [(local + 1) / 2]])
        first, second = work.add_nodes(shape_values(block.kind, halves) @ work.nodes[row]).tolist()
        rows = [[row[0], node, first], [node, row[1], second]]
    assert block.orientation is not None
    turned = np.repeat(block.orientation[element][None], 2, axis=0)
    work.replace_elements(
        block.segment, [(index, np.array([element]))], [(block.kind, np.array(rows, dtype=np.int64), turned)]
    )


# ---------------------------------------------------------------- shells


def _in_shell(work: Workpiece, found: Found, place: Array, reach: float) -> tuple[int, str]:
    block = work.blocks[found.block]
    segment = block.segment
    fitted = surface_of(work, segment, found.place)  # not the place itself, which may lie on a cylinder's axis
    corners = block.connectivity[found.element, : ELEMENT_KINDS[block.kind].n_corner]
    extent = float(np.linalg.norm(np.ptp(work.nodes[corners], axis=0)))
    on = fitted.lift(fitted.flat(place[None]))[0]
    if found.distance > BULGE * extent:
        within = fitted.lift(fitted.flat(found.place[None]))[0]
        _refuse_off(place, within, reach, segment)
        on = within
    around = shells_about(work, segment, on)
    about = around.nodes(len(work.nodes))
    about[corners] = True
    kept = kept_edges(work, segment, about)
    nearest = _nearest_kept(work, block, found.element, fitted, on, kept)
    if nearest is not None:
        edge, share, beside, length, foot = nearest
        if beside <= max(reach, AT_PLACE * length):
            return _on_curve(work, edge, share, foot, place, reach)
        if beside < TOO_NEAR * length:
            raise OptionError(
                f"{place_text(place)} lies {beside:.4g} beside an edge of {segment}, expected a place on it, such as "
                f"{place_text(foot)}, or further than {TOO_NEAR * length:.4g} from it"
            )
    _refuse_off(place, on, reach, f"the mid-surface of {segment}")
    node = int(work.add_nodes(on[None])[0])
    quality = insert_in_patch(work, segment, fitted, node, around, kept)
    return node, f"{segment}, whose worst element about it has a scaled Jacobian of {quality:.2f}"


def _nearest_kept(
    work: Workpiece, block: ElementBlock, element: int, fitted: Fitted, place: Array, kept: set[Edge]
) -> tuple[Edge, float, float, float, Array] | None:
    """Of the element's edges that must stay the one nearest to a place.

    (edge, share along it, distance, length, place on it), measured on the surface rolled out flat.
    """
    best: tuple[Edge, float, float, float, Array] | None = None
    row = block.connectivity[element].tolist()
    for a, b in ELEMENT_KINDS[block.kind].edges:
        edge = (min(row[a], row[b]), max(row[a], row[b]))
        if edge not in kept:
            continue
        kind, numbers = _line_of(work, edge)
        flat = np.column_stack([fitted.flat(work.nodes[numbers]), np.zeros(len(numbers))])
        at = np.append(fitted.flat(place[None])[0], 0.0)
        local, on = project_on(kind, flat, at)
        beside = float(np.linalg.norm(at - on))
        if best is None or beside < best[2]:
            length = float(np.linalg.norm(flat[1] - flat[0]))
            best = edge, float(local[0] + 1) / 2, beside, length, fitted.lift(on[None, :2])[0]
    return best


def _line_of(work: Workpiece, edge: Edge) -> tuple[str, list[int]]:
    """The edge as a line element: its kind and nodes."""
    middle = work.middles.get(edge)
    return ("line2", list(edge)) if middle is None else ("line3", [*edge, middle])


def _on_curve(work: Workpiece, edge: Edge, share: float, on: Array, place: Array, reach: float) -> tuple[int, str]:
    """Split an edge in every segment that has it. on: where the place falls on it, share of the way along."""
    arms = work.reference.arms.reshape(-1, 2, 2)
    if (np.sort(arms, axis=2) == edge).all(axis=2).any():
        raise MeshError(f"the edge at {place_text(place)} hangs by rigid arms, or carries them: it cannot be split")
    segments: dict[str, str] = {}
    for block in work.blocks:
        kind = ELEMENT_KINDS[block.kind]
        has_both = np.isin(block.connectivity[:, : kind.n_corner], edge).sum(axis=1) == 2
        if kind.dimension == 3 and has_both.any():
            raise MeshError(
                f"the edge at {place_text(place)} belongs to solids of {block.segment}, which cannot be split"
            )
        if has_both.any():
            segments[block.segment] = block.kind
    middle = work.middles.get(edge)
    if middle is not None and middle in work.held:
        raise MeshError(f"the mid-side node of the edge at {place_text(place)} is held by a coupling")
    fits = {name: surface_of(work, name, place) for name, kind in segments.items() if not kind.startswith("line")}
    line, numbers = _line_of(work, edge)
    halves = shape_values(line, np.array([[share - 1], [share]])) @ work.nodes[numbers]
    on = _onto(list(fits.values()), on, work.reference.size)
    _refuse_off(place, on, reach, "the curve")
    node = int(work.add_nodes(on[None])[0])
    if middle is not None:
        for corner, half in zip(edge, work.add_nodes(halves).tolist()):
            work.middles[min(corner, node), max(corner, node)] = half
    qualities = []
    for name, fitted in fits.items():
        around = shells_about(work, name, on, edge)
        kept = kept_edges(work, name, around.nodes(len(work.nodes))) | {edge}
        qualities.append(insert_in_patch(work, name, fitted, node, around, kept, Split(*edge, node)))
    for index in range(len(work.blocks)):
        block = work.blocks[index]
        if ELEMENT_KINDS[block.kind].dimension == 1:
            for element in np.flatnonzero(np.isin(block.connectivity[:, :2], edge).sum(axis=1) == 2).tolist()[::-1]:
                forward = int(block.connectivity[element, 0]) == edge[0]
                _split_line(work, index, element, node, (2 * share - 1) * (1 if forward else -1))
    work.split_edge(*edge, node)
    told = f", worst scaled Jacobian {min(qualities):.2f}" if qualities else ""
    return node, f"the curve of {' and '.join(segments)}{told}"


def _onto(fits: list[Fitted], place: Array, size: float) -> Array:
    """A place brought onto all surfaces, one after the other until it stays. size: of the model."""
    for _ in range(50):
        before = place
        for fitted in fits:
            place = fitted.lift(fitted.flat(place[None]))[0]
        if np.linalg.norm(place - before) <= STAYS * max(size, float(np.abs(place).max())):
            break
    return place
