#!/usr/bin/env python3
"""Writes pusher.obj and pusher_cage.obj beside this script. Millimetres; x lateral, y forward, z up.

The pusher is a plain bar: x -52..52, front face at y = 0, 12 thick behind it, z 0..20. The cage is a box
one millimetre larger all around, cut at six stations along x: tips, middles of the wings, ends of the
middle part. Station s has cage vertices 4s..4s+3 (from 0): back-bottom, front-bottom, front-top, back-top.
"""
import pathlib

STATIONS = [-52, -37, -22, 22, 37, 52]  # tip, mid-wing, middle end, and mirrored
Y = (-12, 0)
Z = (0, 20)
MARGIN = 1  # of the cage around the bar
CELLS_X = [8, 8, 22, 8, 8]  # cells between stations, about 2 mm each
CELLS_Y = 5
CELLS_Z = 8


def spread(begin, end, cells):
    return [begin + (end - begin) * i / cells for i in range(cells + 1)]


def make_box(xs, ys, zs):
    """The surface of a grid of boxes: vertices in rings around x, then the inner vertices of the two end
    faces. Every triangle is counter-clockwise from outside. Diagonals mirror about the middle of each face,
    so that the mesh is as symmetric as the bar."""
    vertices, number = [], {}

    def vertex(i, j, k):
        key = (i, j, k)
        if key not in number:
            number[key] = len(vertices)
            vertices.append((xs[i], ys[j], zs[k]))
        return number[key]

    nx, ny, nz = len(xs) - 1, len(ys) - 1, len(zs) - 1
    ring = (
        [(j, 0) for j in range(ny)]
        + [(ny, k) for k in range(nz)]
        + [(j, nz) for j in range(ny, 0, -1)]
        + [(0, k) for k in range(nz, 0, -1)]
    )
    for i in range(nx + 1):
        for j, k in ring:
            vertex(i, j, k)

    triangles = []

    def quad(a, b, c, d, mirrored):
        if mirrored:
            triangles.extend([(b, c, d), (b, d, a)])
        else:
            triangles.extend([(a, b, c), (a, c, d)])

    for i in range(nx):
        for n, (j, k) in enumerate(ring):
            jn, kn = ring[(n + 1) % len(ring)]
            along = j + jn >= ny if k == kn else k + kn >= nz
            quad(vertex(i, j, k), vertex(i, jn, kn), vertex(i + 1, jn, kn), vertex(i + 1, j, k),
                 (2 * i + 1 > nx) != along)
    for j in range(ny):
        for k in range(nz):
            mirrored = (2 * j + 1 > ny) != (2 * k + 1 > nz)
            quad(vertex(0, j, k), vertex(0, j, k + 1), vertex(0, j + 1, k + 1), vertex(0, j + 1, k), mirrored)
            quad(vertex(nx, j, k), vertex(nx, j + 1, k), vertex(nx, j + 1, k + 1), vertex(nx, j, k + 1), not mirrored)
    return vertices, triangles


def write_obj(name, title, vertices, triangles):
    lines = [f"# {title}; millimetres; made by make_pusher.py"]
    lines += [f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    pathlib.Path(__file__).with_name(name).write_text("\n".join(lines) + "\n")


def main():
    xs = [STATIONS[0]]
    for begin, end, cells in zip(STATIONS, STATIONS[1:], CELLS_X):
        xs += spread(begin, end, cells)[1:]
    write_obj("pusher.obj", "Pusher, a plain bar", *make_box(xs, spread(*Y, CELLS_Y), spread(*Z, CELLS_Z)))

    tip = STATIONS[-1] + MARGIN
    write_obj("pusher_cage.obj", "Cage of the pusher",
              *make_box([-tip, *STATIONS[1:-1], tip], [Y[0] - MARGIN, Y[1] + MARGIN], [Z[0] - MARGIN, Z[1] + MARGIN]))


if __name__ == "__main__":
    main()
