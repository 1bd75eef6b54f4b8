r"""Stars: the section of walls that meet on a line, each a ray with half its thickness on either side.

       \  v                  Between neighbouring rays u and v, of opening a, the material is a polygon
        \ ____P              O, R u, R u + t/2 n, P, R v + t'/2 n', R v
         O_______ u         with P at t/2 from u and at t'/2 from v. In a sector of more than 180 degrees
                            P is the tip of the mitre. Level rays of one thickness have no P.

The mid-surfaces count t R + t' R for the walls' whole thickness. What they count more than the material is the
excess.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVEL = 1e-6
"""Rays that leave the line in opposite directions to within this angle (radians) are level."""

LEAST_SINE = 0.17
"""Rays nearer than 10 degrees to one another, or to level, have no excess that could be named."""

LONG = 100.0
"""Length to which rays are followed, in thicknesses."""


def star_excess(angles: Array, thicknesses: Array) -> Array:
    """Excess of area (n,) of n stars; nan where two rays of one are too near.

    angles: (ray, n) radians; thicknesses: (ray, n), or (ray, 1) where all stars have the same. By sector
    [(t^2 + t'^2) cos a + 2 t t'] / (8 sin a).
    """
    order = np.argsort(angles, axis=0)
    turned = np.take_along_axis(angles, order, axis=0)
    first = np.take_along_axis(np.broadcast_to(thicknesses, angles.shape), order, axis=0)
    second = np.roll(first, -1, axis=0)
    openings = np.diff(np.vstack([turned, turned[:1] + 2 * np.pi]), axis=0)
    is_level = (np.abs(openings - np.pi) < LEVEL) & (first == second)
    sine = np.where(is_level, 1.0, np.sin(openings))
    sine[:, np.abs(sine).min(axis=0) < LEAST_SINE] = np.nan
    sectors = ((first**2 + second**2) * np.cos(openings) + 2 * first * second) / (8 * sine)
    excess = np.where(is_level, 0.0, sectors).sum(axis=0)
    return np.asarray(np.where(np.isnan(sine).any(axis=0), np.nan, excess))


def star_moment(rays: Array, thicknesses: Array) -> Array:
    """First moment (2,) of a star's excess about its line. rays: (ray, 2) unit vectors, none too near another."""
    order = np.argsort(np.arctan2(rays[:, 1], rays[:, 0]))
    rays, thicknesses = rays[order], thicknesses[order]
    reach = LONG * float(thicknesses.max())
    moment = np.asarray(0.5 * reach**2 * thicknesses @ rays)
    for place in range(len(rays)):
        other = (place + 1) % len(rays)
        u, v, half = rays[place], rays[other], 0.5 * thicknesses[[place, other]]
        normals = np.array([[-u[1], u[0]], [v[1], -v[0]]])
        sine = u[0] * v[1] - u[1] * v[0]
        tip = [np.linalg.solve(normals, half)] if abs(sine) > LEVEL else []
        ends = [reach * u + half[0] * normals[0], *tip, reach * v + half[1] * normals[1]]
        moment = moment - _polygon_moment(np.array([np.zeros(2), reach * u, *ends, reach * v]))
    return moment


def _polygon_moment(points: Array) -> Array:
    """Integral (2,) of the place over a polygon, counter-clockwise."""
    following = np.roll(points, -1, axis=0)
    cross = points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]
    return np.asarray(cross @ (points + following) / 6)
