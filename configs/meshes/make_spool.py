#!/usr/bin/env python3
"""Writes spool.obj and spool_cage.obj beside this script. Millimetres; x along the spool's axis.

The spool is a square prism, 90 long and 50 wide, centred at the origin. The cage is the same box, cut at four
stations along x: both ends and the two ends of the middle part, where the rope is laid. Station s has cage vertices
4s..4s+3 (from 0), in the order -y-z, +y-z, +y+z, -y+z. The spool's surface lies on the cage, so that the lengths of
the cage's sides are those of the spool.
"""
from box_mesh import make_box, spread, spread_between, write_obj

STATIONS = [-45, -15, 15, 45]
SIDE = [-25, 25]
CELLS_X = [3, 3, 3]  # cells between stations
CELLS = 4  # along a side


def main():
    xs = spread_between(STATIONS, CELLS_X)
    sides = spread(*SIDE, CELLS)
    write_obj(__file__, "spool.obj", "Spool, a square prism", *make_box(xs, sides, sides))
    write_obj(__file__, "spool_cage.obj", "Cage of the spool", *make_box(STATIONS, SIDE, SIDE))


if __name__ == "__main__":
    main()
