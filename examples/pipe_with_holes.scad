// A thin pipe with a hole right through and a larger one on one side, mm.
$fa = 3; $fs = 0.2;
length = 500; radius = 60; wall = 4;

difference() {
    cylinder(h = length, r = radius);
    translate([0, 0, -1]) cylinder(h = length + 2, r = radius - wall);
    translate([-80, 0, 150]) rotate([0, 90, 0]) cylinder(h = 160, r = 18);
    translate([0, -80, 350]) rotate([-90, 0, 0]) cylinder(h = 80, r = 25);
}
