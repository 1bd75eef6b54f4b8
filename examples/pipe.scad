// A thin pipe, mm.
$fa = 3; $fs = 0.2;
length = 500; radius = 60; wall = 4;

difference() {
    cylinder(h = length, r = radius);
    translate([0, 0, -1]) cylinder(h = length + 2, r = radius - wall);
}
