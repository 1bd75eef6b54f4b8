// A table: a top on four legs that touch it from below, mm.
top = [1500, 800, 25]; leg = [50, 50, 760]; inset = 30;

translate([0, 0, leg.z]) cube(top);
for (x = [inset, top.x - leg.x - inset]) for (y = [inset, top.y - leg.y - inset])
    translate([x, y, 0]) cube(leg);
