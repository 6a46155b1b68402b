#!/usr/bin/env python3
"""make_own_tools.py FOLDER: plate.stl, spatula.stl and hook.stl, as somebody's CAD might save them (text, millimetres).

Each is a union of boxes, whose surface has a square of two triangles for every face of a cell of 4 mm."""

import pathlib
import sys

CELL = 4

TOOLS = {
    # Boxes by their corners [mm]. A plate that looks along +y …
    "plate": [((-48, -8, 0), (48, 0, 20))],
    # … a handle with a blade, which looks along +x …
    "spatula": [((-4, -72, 0), (4, 0, 12)), ((-12, 0, 0), (12, 64, 12))],
    # … and a shaft with a bar across its end, which looks along -y.
    "hook": [((0, 0, 0), (8, 80, 16)), ((8, 72, 0), (72, 80, 16))],
}


def list_cells(boxes):
    cells = set()
    for low, high in boxes:
        ranges = [range(a // CELL, b // CELL) for a, b in zip(low, high)]
        cells |= {(i, j, k) for i in ranges[0] for j in ranges[1] for k in ranges[2]}
    return cells


def list_triangles(cells):
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beside = list(cell)
                beside[axis] += 1 if side else -1
                if tuple(beside) in cells:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                corners = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[u] += du
                    corner[v] += dv
                    corners.append(tuple(CELL * x for x in corner))
                if not side:
                    corners.reverse()
                yield corners[0], corners[1], corners[2]
                yield corners[0], corners[2], corners[3]


def main():
    folder = pathlib.Path(sys.argv[1])
    for name, boxes in TOOLS.items():
        lines = [f"solid {name}"]
        for triangle in list_triangles(list_cells(boxes)):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x} {y} {z}" for x, y, z in triangle]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
        (folder / f"{name}.stl").write_text("\n".join(lines) + "\n", encoding="utf-8")


main()
