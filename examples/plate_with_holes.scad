// A plate with six bolt holes, mm.
$fa = 3; $fs = 0.2;
length = 240; width = 120; thickness = 8; hole = 20;

difference() {
    cube([length, width, thickness]);
    for (x = [40, 120, 200], y = [35, 85])
        translate([x, y, -1]) cylinder(h = thickness + 2, d = hole);
}
