"""Which things hang together: near points, pieces of a graph; mostly without scipy, whose import takes 0.2 s."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

MAX_SLICE_PAIRS = 2_000_000
"""Candidates that the sweep may hold at once."""


def connected_pieces(count: int, first: Indices, second: Indices) -> Indices:
    """(count,) for each of `count` things the smallest of its piece, where first[k] and second[k] hang together.

    The smallest is passed on until nothing changes (hooking and pointer jumping; Shiloach and Vishkin 1982).
    """
    labels = np.arange(count)
    while len(first):
        low = np.minimum(labels[first], labels[second])
        before = labels.copy()
        np.minimum.at(labels, labels[first], low)  # hook the roots
        np.minimum.at(labels, labels[second], low)
        while True:  # then shorten the paths
            jumped = labels[labels]
            if np.array_equal(jumped, labels):
                break
            labels = jumped
        if np.array_equal(labels, before):
            break
    return labels


def near_pairs(points: NDArray[np.float64], tolerance: float) -> list[tuple[int, int]]:
    """All pairs (i < j) of points (n, 3) nearer than the tolerance, by a sweep along x: few share so narrow a slice."""
    order = np.lexsort((points[:, 2], points[:, 1], points[:, 0]))
    x = points[order, 0]
    ends = np.searchsorted(x, x + tolerance, side="right")
    counts = ends - np.arange(len(x)) - 1
    if counts.sum() > MAX_SLICE_PAIRS:  # many nodes in planes across x: a tree is better there
        from scipy.spatial import cKDTree

        return sorted(cKDTree(points).query_pairs(tolerance))
    first = np.repeat(np.arange(len(x)), counts)
    second = first + 1 + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    near = np.linalg.norm(points[order[first]] - points[order[second]], axis=1) < tolerance
    pairs = np.sort(np.column_stack([order[first[near]], order[second[near]]]), axis=1)
    return sorted((int(a), int(b)) for a, b in pairs)
