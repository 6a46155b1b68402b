"""Boxes cut into triangles, and their files. Lengths in the unit of the caller."""
import pathlib


def spread(begin, end, cells):
    return [begin + (end - begin) * i / cells for i in range(cells + 1)]


def spread_between(stations, cells):
    """The stations and `cells[i]` equal cells from station i to the next."""
    xs = [stations[0]]
    for begin, end, count in zip(stations, stations[1:], cells):
        xs += spread(begin, end, count)[1:]
    return xs


def make_box(xs, ys, zs):
    """The surface of a grid of boxes: vertices in rings around x, then the inner vertices of the two end
    faces. Every triangle is counter-clockwise from outside. Diagonals mirror about the middle of each face,
    so that the mesh is as symmetric as the box."""
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


def write_obj(script, name, title, vertices, triangles):
    """Beside the script, which the file names as its maker."""
    script = pathlib.Path(script)
    lines = [f"# {title}; millimetres; made by {script.name}"]
    lines += [f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    script.with_name(name).write_text("\n".join(lines) + "\n")
