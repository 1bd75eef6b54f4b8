"""A polyhedron from points and faces as people write them: closed, its faces planar, its outside outside."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from kernel.csg.tree import Matrix, Polyhedron, frozen_array
from kernel.errors import Place, ReadError

_PLANAR_TOLERANCE = 1e-5
"""Relative to the polyhedron's size: six digits."""


def closed_polyhedron(points: Matrix, faces: Sequence[Sequence[int]], place: Place | None) -> Polyhedron:
    """Equal points made one, bent faces cut into triangles, all faces turned if they look inwards.

    ReadError: an edge that does not belong to exactly two faces, once each way; no volume.
    """
    unique, first = _merged(points)
    merged = [_without_repeats([first[index] for index in face]) for face in faces]
    size = float(np.ptp(unique, axis=0).max())
    flat: list[tuple[int, ...]] = []
    for face in merged:
        if len(face) >= 3:
            flat += [face] if _is_planar(unique[list(face)], size) else _fan(face)
    _check_closed(flat, place)
    volume = _volume(unique, flat)
    if abs(volume) <= 1e-15 * size**3:
        raise ReadError("polyhedron encloses no volume, expected a closed surface", place=place)
    if volume > 0:  # seen from outside its faces run counter-clockwise: turn them
        flat = [face[::-1] for face in flat]
    return Polyhedron(points=frozen_array(unique), faces=tuple(flat), place=place)


def _merged(points: Matrix) -> tuple[Matrix, list[int]]:
    """(points without repeats, in order of first use; number of each point among them)."""
    numbers: dict[tuple[float, ...], int] = {}
    first = [numbers.setdefault(tuple(point), len(numbers)) for point in (points + 0.0).tolist()]
    return np.array(list(numbers)), first


def _without_repeats(face: list[int]) -> tuple[int, ...]:
    return tuple(index for position, index in enumerate(face) if index != face[position - 1])


def _is_planar(corners: Matrix, size: float) -> bool:
    if len(corners) == 3:
        return True
    _, _, axes = np.linalg.svd(corners - corners.mean(axis=0))
    return bool(np.abs((corners - corners.mean(axis=0)) @ axes[2]).max() <= _PLANAR_TOLERANCE * size)


def _fan(face: tuple[int, ...]) -> list[tuple[int, ...]]:
    return [(face[0], face[index], face[index + 1]) for index in range(1, len(face) - 1)]


def _check_closed(faces: list[tuple[int, ...]], place: Place | None) -> None:
    edges = Counter((a, b) for face in faces for a, b in zip(face, (*face[1:], face[0])))
    for (a, b), count in edges.items():
        n_face = count + edges[b, a]
        if count > 1 or n_face != 2:
            faces_found = {1: "1 face", 2: "2 faces that run the same way"}.get(n_face, f"{n_face} faces")
            raise ReadError(
                f"polyhedron is not closed: the edge between points {a} and {b} belongs to {faces_found}, "
                "expected two that run opposite ways",
                place=place,
            )


def _volume(points: Matrix, faces: list[tuple[int, ...]]) -> float:
    """Signed: positive where faces run counter-clockwise seen from outside."""
    triangles = np.array([triangle for face in faces for triangle in _fan(face)])
    a, b, c = (points[triangles[:, corner]] - points[0] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
