#!/usr/bin/env python3
"""Writes the links of the finger of configs/reaching.yaml, those of the arm of configs/flipping.yaml, and their cages
beside this script.

The arm's links have the finger's measures, with the axes where DiffHand's Flipping has them, and fewer triangles, since
they touch.

Millimetres; x along the finger, z up. A link's origin is on its axis of rotation where it has one, else at its start.
A cage is a box cut into rectangles along x, four vertices each, in the order (-y, -z), (+y, -z), (+y, +z), (-y, +z):
vertices 0 to 3 at the start, the last four at the end. The tip has one in the middle too, so that the middle of its
upper face lies on an edge of the cage and stays there however the ends change. The link inside is a rounded bar that
touches the middle of the cage's faces: rings of a superellipse |y/b|^4 + |z/h|^4 = 1.
"""
import math
import pathlib

# Vertices of a ring, inner rings of an end face, and where along a link its rings are, by the shape of its ends.
TWELFTHS = [i / 12 for i in range(13)]
FINE = (32, 2, {"flat": TWELFTHS, "chamfered": TWELFTHS, "round": TWELFTHS})
COARSE = (16, 0, {"flat": [0, 0.5, 1], "chamfered": [0, 0.125, 0.875, 1], "round": [0, 1 / 3, 2 / 3, 0.8, 0.9, 1]})

# name: (start, end, width and height at the start, at the end, shape of the ends)
FINGER = {
    "finger_palm": (0, 7, (16, 32.4), (16, 32.4), "flat"),
    "finger_knuckle": (-16, 11.5, (16, 32.4), (26, 26), "chamfered"),
    "finger_joint": (-9.8, 10.8, (26, 26), (26, 26), "chamfered"),
    "finger_phalanx": (0, 23.4, (26, 26), (26, 26), "flat"),
    "finger_tip": (0, 22.1, (26, 26), (26, 26), "round"),
}
ARM = {
    "arm_palm": (0, 7, (16, 32.4), (16, 32.4), "flat"),
    "arm_knuckle": (-11.5, 16, (16, 32.4), (26, 26), "chamfered"),
    "arm_joint": (-10.8, 9.8, (26, 26), (26, 26), "chamfered"),
    "arm_phalanx": (0, 23.4, (26, 26), (26, 26), "flat"),
    "arm_tip": (0, 22.1, (26, 26), (26, 26), "round"),
}


def make_profile(ends, places):
    """(place along the link, size of the section there), both as fractions."""
    if ends == "chamfered":
        return [(s, 1 - 0.1 * max(0, 1 - 8 * min(s, 1 - s))) for s in places]
    if ends == "round":  # the last third is half an ellipsoid, cut at 30% of its section
        return [(s, math.sqrt(1 - 0.91 * max(0, 3 * s - 2) ** 2)) for s in places]
    return [(s, 1) for s in places]


def round_off(x):
    return math.copysign(math.sqrt(abs(x)), x) if abs(x) > 1e-12 else 0.0


def make_link(fineness, start, end, size0, size1, ends):
    around, cap_rings, places = fineness
    vertices, triangles = [], []

    def add_ring(s, size):
        first = len(vertices)
        half = [0.5 * size * (a + (b - a) * s) for a, b in zip(size0, size1)]
        for k in range(around):
            angle = 2 * math.pi * k / around
            vertices.append((start + (end - start) * s, half[0] * round_off(math.cos(angle)),
                             half[1] * round_off(math.sin(angle))))
        return first

    def join(a, b):
        for k in range(around):
            n = (k + 1) % around
            triangles.extend([(a + k, a + n, b + n), (a + k, b + n, b + k)])

    def close(ring, s, size, at_end):
        for i in range(cap_rings, 0, -1):
            inner = add_ring(s, size * i / (cap_rings + 1))
            join(*((ring, inner) if at_end else (inner, ring)))
            ring = inner
        center = len(vertices)
        vertices.append((start + (end - start) * s, 0.0, 0.0))
        for k in range(around):
            n = (k + 1) % around
            triangles.append((ring + k, ring + n, center) if at_end else (ring + n, ring + k, center))

    profile = make_profile(ends, places[ends])
    rings = [add_ring(s, size) for s, size in profile]
    for a, b in zip(rings, rings[1:]):
        join(a, b)
    close(rings[0], *profile[0], False)
    close(rings[-1], *profile[-1], True)
    return vertices, triangles


def make_cage(start, end, size0, size1, ends):
    stations = [0, 0.5, 1] if ends == "round" else [0, 1]
    vertices, triangles = [], []

    def quad(a, b, c, d):
        triangles.extend([(a, b, c), (a, c, d)])

    for s in stations:
        width, height = (a + (b - a) * s for a, b in zip(size0, size1))
        vertices += [(start + (end - start) * s, y * width / 2, z * height / 2)
                     for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    last = len(vertices) - 4
    quad(0, 3, 2, 1)
    quad(last, last + 1, last + 2, last + 3)
    for first in range(0, last, 4):
        for k in range(4):
            n = (k + 1) % 4
            quad(first + k, first + n, first + 4 + n, first + 4 + k)
    return vertices, triangles


def write_obj(name, title, vertices, triangles):
    lines = [f"# {title}; millimetres; made by make_finger.py"]
    lines += [f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    pathlib.Path(__file__).with_name(name + ".obj").write_text("\n".join(lines) + "\n")


def main():
    for links, fineness in ((FINGER, FINE), (ARM, COARSE)):
        for name, link in links.items():
            write_obj(name, name.replace("_", " ").capitalize(), *make_link(fineness, *link))
            write_obj(name + "_cage", "Cage of the " + name.replace("_", " "), *make_cage(*link))


if __name__ == "__main__":
    main()
