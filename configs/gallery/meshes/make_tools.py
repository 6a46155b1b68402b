#!/usr/bin/env python3
"""Writes the tools of the gallery and their cages beside this script. Millimetres.

blade: a bar, x -50..50, 10 thick, z 0..20, whose front face is a little hollow: at y = 0 in the middle, 3 and 10 ahead
halfway and at the tips. rake: the same, but straight. Their cages are cut at five stations along x: left tip, left
middle, centre, right middle, right tip. finger: a bar 8 x 8 that hangs from the origin down to z = -40,
with a cage cut at its ends. Station s has cage vertices 4s..4s+3 (from 0). funnel: a flat ring around z, 12 to 60 from
the axis, 5 thick; its cage has eight columns around, from +x counter-clockwise, of vertices 6c..6c+5: inner, middle and
outer, below and above. dustpan: a floor, x -16..16, y -36..0, that rises from a lip at y = 0, 1.2 high, to 6 at
y = -28, and a back behind it, 12 high; its cage is cut at y = -36, -34, -28, -14 and 0.
hook: a bar 6 x 6 along y, -60..20, with a cage cut at its ends, at -20 and at 0. ring: what it lifts, around z.
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "meshes"))
from box_mesh import make_box, spread, spread_between, write_obj  # noqa: E402

MARGIN = 1  # of the cages around the tools


STATIONS = [-50, -25, 0, 25, 50]
AHEAD = [10, 3, 0, 3, 10]


def hollow(vertices):
    """Moves what lies along x ahead, between the stations in straight lines."""
    def ahead(x):
        x = min(max(x, STATIONS[0]), STATIONS[-1])
        i = min(sum(x >= station for station in STATIONS), len(STATIONS) - 1)
        share = (x - STATIONS[i - 1]) / (STATIONS[i] - STATIONS[i - 1])
        return AHEAD[i - 1] + share * (AHEAD[i] - AHEAD[i - 1])
    return [(x, y + ahead(x), z) for x, y, z in vertices]


def write_bar(name, shape):
    xs = spread_between(STATIONS, [10, 10, 10, 10])
    vertices, triangles = make_box(xs, spread(-10, 0, 2), spread(0, 20, 2))
    write_obj(__file__, f"{name}.obj", f"{name.capitalize()}, a bar", shape(vertices), triangles)
    tip = STATIONS[-1] + MARGIN
    vertices, triangles = make_box([-tip, *STATIONS[1:-1], tip], [-10 - MARGIN, MARGIN], [-MARGIN, 20 + MARGIN])
    write_obj(__file__, f"{name}_cage.obj", f"Cage of the {name}", shape(vertices), triangles)


def turn(vertices):
    """x becomes -z: what lies along x hangs down."""
    return [(z, y, -x) for x, y, z in vertices]


def write_finger():
    vertices, triangles = make_box(spread(0, 40, 8), spread(-4, 4, 2), spread(-4, 4, 2))
    write_obj(__file__, "finger.obj", "Finger, a plain bar", turn(vertices), triangles)
    vertices, triangles = make_box([-MARGIN, 40 + MARGIN], [-5, 5], [-5, 5])
    write_obj(__file__, "finger_cage.obj", "Cage of the finger", turn(vertices), triangles)


def make_ring(section, around):
    """What a closed section, counter-clockwise in (radius, z), sweeps around z: vertices column by column."""
    count = len(section)
    vertices = []
    for c in range(around):
        angle = 2 * math.pi * c / around
        vertices += [(r * math.cos(angle), r * math.sin(angle), z) for r, z in section]
    triangles = []
    for c in range(around):
        here, there = c * count, (c + 1) % around * count
        for i in range(count):
            j = (i + 1) % count
            triangles += [(here + i, there + j, here + j), (here + i, there + i, there + j)]
    return vertices, triangles


def write_funnel():
    def section(radii, low, high):
        return [(r, low) for r in radii] + [(r, high) for r in reversed(radii)]

    vertices, triangles = make_ring(section([12, 28, 44, 60], -5, 0), 24)
    write_obj(__file__, "funnel.obj", "Funnel, a flat ring", vertices, triangles)
    vertices, triangles = make_ring(section([12 - MARGIN, 36, 60 + 6 * MARGIN], -5 - MARGIN, MARGIN), 8)
    write_obj(__file__, "funnel_cage.obj", "Cage of the funnel", vertices, triangles)


def write_dustpan():
    heights = [(-37, 12), (-34, 12), (-28, 6), (0, 1.2), (1, 1.2)]

    def height(y):
        i = next(i for i in range(1, len(heights)) if y <= heights[i][0])
        (y0, z0), (y1, z1) = heights[i - 1], heights[i]
        return z0 + (z1 - z0) * (y - y0) / (y1 - y0)

    def shape(vertices, below=0, above=0):
        """z is the share of the height at y."""
        return [(x, y, z * height(y) - below * (1 - z) + above * z) for y, x, z in vertices]

    def turn_over(triangles):
        return [(a, c, b) for a, b, c in triangles]

    ys = spread_between([-36, -34, -28, 0], [1, 1, 4])
    vertices, triangles = make_box(ys, spread(-16, 16, 2), [0, 1])
    write_obj(__file__, "dustpan.obj", "Dustpan", shape(vertices), turn_over(triangles))
    vertices, triangles = make_box([-37, -34, -28, -14, 1], [-17, 17], [0, 1])
    cage = shape(vertices, MARGIN, MARGIN)
    write_obj(__file__, "dustpan_cage.obj", "Cage of the dustpan", cage, turn_over(triangles))


def write_hook():
    def turn_along(vertices):
        """x becomes y, and y becomes -x."""
        return [(-y, x, z) for x, y, z in vertices]

    xs = spread_between([-60, -20, 0, 20], [2, 2, 3])
    vertices, triangles = make_box(xs, [-3, 0, 3], [-3, 0, 3])
    write_obj(__file__, "hook.obj", "Hook, a straight bar", turn_along(vertices), triangles)
    vertices, triangles = make_box([-60 - MARGIN, -20, 0, 20 + MARGIN], [-3 - MARGIN, 3 + MARGIN],
                                   [-3 - MARGIN, 3 + MARGIN])
    write_obj(__file__, "hook_cage.obj", "Cage of the hook", turn_along(vertices), triangles)


def write_torus():
    tube = [(18 + 4 * math.cos(math.pi * i / 4), 4 * math.sin(math.pi * i / 4)) for i in range(8)]
    vertices, triangles = make_ring(tube, 12)
    write_obj(__file__, "ring.obj", "A ring, 18 from its axis, of a tube 4 in radius", vertices, triangles)


if __name__ == "__main__":
    write_bar("blade", hollow)
    write_bar("rake", list)
    write_finger()
    write_funnel()
    write_dustpan()
    write_hook()
    write_torus()
