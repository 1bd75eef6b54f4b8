"""Exact orientation and in-circle tests on integer coordinates below 2^30.

With |coordinate| <= 2^30 a difference has 31 bits, orient's products 62 and their difference fits int64. The
in-circle determinant needs 125 bits: a floating-point filter answers all but the nearly cocircular (Shewchuk 1997,
Adaptive Precision Floating-Point Arithmetic), and those are summed in limbs of 31 bits.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled

_LIMB = 31
_LIMB_MASK = (1 << 31) - 1

_FILTER = 1.2e-15
"""More than (4 + 2^-50) epsilon times the permanent: the error bound of the floating-point determinant."""


@compiled
def orient(x, y, a, b, c):
    """Twice the signed area of nodes a, b, c: positive counter-clockwise. x, y: (n_node,) int64."""
    return (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])


@compiled
def _incircle_exact(ax, ay, bx, by, cx, cy):
    """Sign of sum of |a|^2 (b x c), cyclic, with int64 differences to the fourth point."""
    high = np.int64(0)
    middle = np.int64(0)
    low = np.int64(0)
    for k in range(3):
        if k == 0:
            lift = ax * ax + ay * ay
            cross = bx * cy - by * cx
        elif k == 1:
            lift = bx * bx + by * by
            cross = cx * ay - cy * ax
        else:
            lift = cx * cx + cy * cy
            cross = ax * by - ay * bx
        lift_high = lift >> _LIMB
        lift_low = lift & _LIMB_MASK
        cross_high = cross >> _LIMB
        cross_low = cross & _LIMB_MASK
        product_low = lift_low * cross_low
        product_middle = lift_high * cross_low + lift_low * cross_high + (product_low >> _LIMB)
        low += product_low & _LIMB_MASK
        middle += product_middle & _LIMB_MASK
        high += lift_high * cross_high + (product_middle >> _LIMB)
    middle += low >> _LIMB
    low &= _LIMB_MASK
    high += middle >> _LIMB
    middle &= _LIMB_MASK
    if high < 0:
        return -1
    if high > 0 or middle > 0 or low > 0:
        return 1
    return 0


@compiled
def incircle(x, y, a, b, c, d):
    """1 where node d is inside the circle through a, b, c (counter-clockwise), 0 on it, -1 outside."""
    int_ax = x[a] - x[d]
    int_ay = y[a] - y[d]
    int_bx = x[b] - x[d]
    int_by = y[b] - y[d]
    int_cx = x[c] - x[d]
    int_cy = y[c] - y[d]
    ax = float(int_ax)
    ay = float(int_ay)
    bx = float(int_bx)
    by = float(int_by)
    cx = float(int_cx)
    cy = float(int_cy)
    a_lift = ax * ax + ay * ay
    b_lift = bx * bx + by * by
    c_lift = cx * cx + cy * cy
    bc = bx * cy
    cb = by * cx
    ca = cx * ay
    ac = cy * ax
    ab = ax * by
    ba = ay * bx
    determinant = a_lift * (bc - cb) + b_lift * (ca - ac) + c_lift * (ab - ba)
    permanent = a_lift * (abs(bc) + abs(cb)) + b_lift * (abs(ca) + abs(ac)) + c_lift * (abs(ab) + abs(ba))
    if determinant > _FILTER * permanent:
        return 1
    if determinant < -_FILTER * permanent:
        return -1
    return _incircle_exact(int_ax, int_ay, int_bx, int_by, int_cx, int_cy)
