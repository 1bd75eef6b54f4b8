"""How far a segment stays from edges on an unrolled cylinder."""

from __future__ import annotations

from kernel.numeric.bins import segment_distance2
from kernel.numeric.compiled import compiled


@compiled
def clearance2(ax, ay, bx, by, from_x, from_y, to_x, to_y, period):
    """Least squared distance of segment a-b from the edges that touch neither end of it; 0 where one crosses."""
    least = 1e300
    for e in range(len(from_x)):
        for turn in range(-1, 2):
            cx = from_x[e] + turn * period
            dx = to_x[e] + turn * period
            cy = from_y[e]
            dy = to_y[e]
            meets_a = (abs(cx - ax) + abs(cy - ay)) * (abs(dx - ax) + abs(dy - ay)) == 0
            meets_b = (abs(cx - bx) + abs(cy - by)) * (abs(dx - bx) + abs(dy - by)) == 0
            if meets_a or meets_b:
                continue
            o1 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            o2 = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
            o3 = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
            o4 = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
            if o1 * o2 <= 0 and o3 * o4 <= 0:
                return 0.0
            least = min(least, segment_distance2(ax, ay, cx, cy, dx, dy))
            least = min(least, segment_distance2(bx, by, cx, cy, dx, dy))
            least = min(least, segment_distance2(cx, cy, ax, ay, bx, by))
            least = min(least, segment_distance2(dx, dy, ax, ay, bx, by))
    return least
