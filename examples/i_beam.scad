// An I-beam of two flanges and a web that touch, mm.
length = 2400; width = 120; depth = 120; flange = 10; web = 8;

union() {
    cube([length, width, flange]);
    translate([0, 0, depth - flange]) cube([length, width, flange]);
    translate([0, (width - web) / 2, flange]) cube([length, web, depth - 2 * flange]);
}
