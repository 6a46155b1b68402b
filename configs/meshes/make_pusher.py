#!/usr/bin/env python3
"""Writes pusher.obj and pusher_cage.obj beside this script. Millimetres; x lateral, y forward, z up.

The pusher is a plain bar: x -52..52, front face at y = 0, 12 thick behind it, z 0..20. The cage is a box
one millimetre larger all around, cut at six stations along x: tips, middles of the wings, ends of the
middle part. Station s has cage vertices 4s..4s+3 (from 0): back-bottom, front-bottom, front-top, back-top.
"""
from box_mesh import make_box, spread, spread_between, write_obj

STATIONS = [-52, -37, -22, 22, 37, 52]  # tip, mid-wing, middle end, and mirrored
Y = (-12, 0)
Z = (0, 20)
MARGIN = 1  # of the cage around the bar
CELLS_X = [8, 8, 22, 8, 8]  # cells between stations, about 2 mm each: it bends along x alone
CELLS_Y = 2
CELLS_Z = 2


def main():
    xs = spread_between(STATIONS, CELLS_X)
    bar = make_box(xs, spread(*Y, CELLS_Y), spread(*Z, CELLS_Z))
    write_obj(__file__, "pusher.obj", "Pusher, a plain bar", *bar)

    tip = STATIONS[-1] + MARGIN
    write_obj(__file__, "pusher_cage.obj", "Cage of the pusher",
              *make_box([-tip, *STATIONS[1:-1], tip], [Y[0] - MARGIN, Y[1] + MARGIN], [Z[0] - MARGIN, Z[1] + MARGIN]))


if __name__ == "__main__":
    main()
