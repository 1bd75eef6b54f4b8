// An angle bracket: base, wall, a gusset between them, and four bolt holes, mm.
$fa = 3; $fs = 0.2;
base = [160, 100, 10]; wall = [10, 100, 140]; gusset = [110, 8, 100]; hole = 14;

difference() {
    union() {
        cube(base);
        cube(wall);
        translate([wall.x, (base.y + gusset.y) / 2, base.z]) rotate([90, 0, 0])
            linear_extrude(gusset.y) polygon([[0, 0], [gusset.x, 0], [0, gusset.z]]);
    }
    for (y = [22, 78]) {
        translate([125, y, -1]) cylinder(h = base.z + 2, d = hole);
        translate([-1, y, 105]) rotate([0, 90, 0]) cylinder(h = wall.x + 2, d = hole);
    }
}
