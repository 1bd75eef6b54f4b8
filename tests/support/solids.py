"""Solids as OpenSCAD text, for tests that read like a drawing."""

from __future__ import annotations

import math

import numpy as np


def turned(axis: str, degrees: float) -> np.ndarray:
    """Rotation (3, 3) about a coordinate axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def placed(text: str, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """A solid moved to `at` after a turn."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if turn is None else turn
    matrix[:3, 3] = at
    rows = ",".join("[" + ",".join(repr(float(x)) for x in row) + "]" for row in matrix)
    return f"multmatrix([{rows}]){{{text}}}"


def cube(x, y, z, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """A block in the positive octant, moved to `at` after a turn."""
    return placed(f"cube(size=[{x},{y},{z}],center=false);", at, turn)


def rod(height, radius, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """A cylinder from its base's middle along z, moved to `at` after a turn."""
    text = f"cylinder($fn=0,$fa=3,$fs=.2,h={height},r1={radius},r2={radius},center=false);"
    return placed(text, at, turn)


def tube(height, outer, inner, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """A rod less its bore."""
    return placed(difference(rod(height, outer), rod(height + 2, inner, (0, 0, -1))), at, turn)


def extrusion(points, height, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """A polygon (n, 2) along z, moved to `at` after a turn."""
    listed = [[float(x), float(y)] for x, y in points]
    polygon = f"polygon(points={listed},paths=undef,convexity=1);"
    return placed(f"linear_extrude(height={height},center=false,convexity=1,scale=[1,1]){{{polygon}}}", at, turn)


def union(*solids: str) -> str:
    return "union(){" + "".join(solids) + "}"


def difference(*solids: str) -> str:
    return "difference(){" + "".join(solids) + "}"


def intersection(*solids: str) -> str:
    return "intersection(){" + "".join(solids) + "}"
