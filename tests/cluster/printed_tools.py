#!/usr/bin/env python3
"""tests/cluster/printed_tools.py KNAP RANDOM SLICED CONFIG...

What `knap export` writes, judged by programs of other people: for the initial design of each scenario, the two corners
of its bounds and RANDOM designs drawn uniformly within them,

- PrusaSlicer reads STL and 3MF as manifold, without an open edge, and with the volume and size that knap says;
- ADMesh finds nothing to mend in the STL;
- PrusaSlicer slices SLICED of the files;
- a design that knap refuses is no body indeed: exact arithmetic finds two triangles that meet, neighbours lie on one
  another, or the volume is not positive. Its mesh is put together from exported ones: theta moves vertices linearly.

Exits with 77 where a program is missing.
"""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from fractions import Fraction

LIMIT_S = 120


def run(command, **kwargs):
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False, **kwargs)


def fail(message):
    print(f"FAILED: {message}")
    sys.exit(1)


# ---- Designs ------------------------------------------------------------------------------------------------------


def list_parameters(knap, config):
    """(name, initial, lower, upper, unit) of the design's parameters, from the plan that knap prints."""
    plan = run([knap, "learn", config, "--dry-run"])
    if plan.returncode != 0:
        fail(f"{config}: {plan.stderr}")
    found = re.findall(r"^  (\S+) +(\S+) in \[(\S+), (\S+)\](?: (m))?(?:, fixed)?$", plan.stdout, re.M)
    return [(n, float(x), float(a), float(b), u) for n, x, a, b, u in found if "[" not in n]


def format_theta(parameters, values):
    return ",".join(f"{p[0]}={v!r}{' m' if p[4] else ''}" for p, v in zip(parameters, values))


def export(knap, config, parameters, values, file):
    """The document of `knap export`, and whether anything was written."""
    ended = run([knap, "export", config, "--theta", format_theta(parameters, values), "--format",
                 file.rsplit(".", 1)[1], "--out", file, "--json"])
    if ended.returncode not in (0, 1) or not ended.stdout:
        fail(f"{config}: knap export ended with {ended.returncode}: {ended.stderr}")
    document = json.loads(ended.stdout)
    if document["written"] != (ended.returncode == 0):
        fail(f"{config}: exit code {ended.returncode}, but written is {document['written']}")
    if ended.returncode == 1 and not any(f["error"] for b in document["bodies"] for f in b["findings"]):
        fail(f"{config}: refused without an error")
    return document


# ---- Judges -------------------------------------------------------------------------------------------------------


def ask_slicer(files):
    """What PrusaSlicer says of each file; its exit code is 0 whatever it says."""
    said = run(["prusa-slicer", "--info", *files])
    parts = re.split(r"^\[(.+)\]$", said.stdout, flags=re.M)[1:]
    # Of several files a later section may tell of the same name again.
    infos = {}
    for name, text in zip(parts[::2], parts[1::2]):
        infos[name] = dict(re.findall(r"^(\w+) += +(\S+)$", text, re.M))
    return infos


def check_slicer(body, file, info):
    if info is None:
        fail(f"{file}: PrusaSlicer says nothing")
    if info.get("manifold") != "yes" or int(info.get("open_edges", "0")) != 0:
        fail(f"{file}: PrusaSlicer: {info}")
    if int(info["number_of_facets"]) != body["triangles"]:
        fail(f"{file}: PrusaSlicer has {info['number_of_facets']} facets, knap {body['triangles']}")
    if abs(float(info["volume"]) - body["volume_mm3"]) > 1e-4 * body["volume_mm3"]:
        fail(f"{file}: PrusaSlicer has {info['volume']} mm³, knap {body['volume_mm3']}")
    for key, size in zip("xyz", body["extent_mm"]):
        if abs(float(info["size_" + key]) - size) > 1e-3:
            fail(f"{file}: PrusaSlicer: {key} is {info['size_' + key]} mm, knap {size}")


def check_admesh(file):
    said = run(["admesh", file]).stdout
    numbers = dict(re.findall(r"^(\w[\w ]+\w) +: +(\d+)", said, re.M))
    wrong = [f"{key} {numbers.get(key)}" for key in
             ("Total disconnected facets", "Degenerate facets", "Edges fixed", "Facets removed", "Facets added",
              "Facets reversed", "Backwards edges", "Normals fixed") if numbers.get(key) != "0"]
    if wrong:
        fail(f"{file}: ADMesh: {', '.join(wrong)}\n{said}")


def check_slicing(file, folder):
    gcode = os.path.join(folder, "tool.gcode")
    said = run(["prusa-slicer", "--export-gcode", file, "--output", gcode, "--bed-shape", "0x0,250x0,250x210,0x210",
                "--support-material", "--brim-width", "3"])
    if not os.path.exists(gcode):
        fail(f"{file}: PrusaSlicer does not slice it: {said.stdout} {said.stderr}")
    with open(gcode, encoding="utf-8") as text:
        layers = len(re.findall(r"^;LAYER_CHANGE$", text.read(), re.M))
    os.remove(gcode)
    return layers


# ---- Refusals -----------------------------------------------------------------------------------------------------


def read_obj(file):
    vertices, triangles = [], []
    with open(file, encoding="utf-8") as text:
        for line in text:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                triangles.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return vertices, triangles


class LinearMesh:
    """One body's vertices as a linear function of theta, from meshes that were exported."""

    def __init__(self, base, steps):
        self.base, self.steps = base, steps  # steps: (change, mesh) or None a parameter

    def at(self, values, initial):
        out = [list(v) for v in self.base]
        for value, first, step in zip(values, initial, self.steps):
            if step is None:
                continue
            share = (value - first) / step[0]
            for vertex, moved, at_rest in zip(out, step[1], self.base):
                for k in range(3):
                    vertex[k] += share * (moved[k] - at_rest[k])
        return out


def make_linear_meshes(knap, config, parameters, folder):
    """By the files' names behind the stem; None where no small enough step gives a body."""
    initial = [p[1] for p in parameters]
    meshes = {}

    def export_all(values, stem):
        document = export(knap, config, parameters, values, os.path.join(folder, stem + ".obj"))
        return {b["body"]: read_obj(b["file"]) for b in document["bodies"]} if document["written"] else None

    base = export_all(initial, "base")
    steps = {body: [] for body in base}
    for i, (_, first, lower, upper, _) in enumerate(parameters):
        for share in (1.0, 0.5, 0.2, 0.05):
            target = upper if upper - first > first - lower else lower
            values = list(initial)
            values[i] = first + share * (target - first)
            moved = export_all(values, "moved")
            if moved is not None:
                break
        else:
            return None
        for body in base:
            steps[body].append((values[i] - first, moved[body][0]))
    for body, (vertices, triangles) in base.items():
        meshes[body] = (LinearMesh(vertices, steps[body]), triangles)
    return meshes


def orient(a, b, c, d):
    """The sign of the volume of a tetrahedron, exactly."""
    u = [a[k] - d[k] for k in range(3)]
    v = [b[k] - d[k] for k in range(3)]
    w = [c[k] - d[k] for k in range(3)]
    det = (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    size = max(max(map(abs, u)), max(map(abs, v)), max(map(abs, w)))
    if abs(det) > 1e-12 * size ** 3:
        return (det > 0) - (det < 0)
    a, b, c, d = ([Fraction(x) for x in p] for p in (a, b, c, d))
    u = [a[k] - d[k] for k in range(3)]
    v = [b[k] - d[k] for k in range(3)]
    w = [c[k] - d[k] for k in range(3)]
    det = (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    return (det > 0) - (det < 0)


def pierces(p, q, triangle):
    """Whether the segment p q meets the triangle at more than touching it."""
    a, b, c = triangle
    if orient(a, b, c, p) * orient(a, b, c, q) >= 0:
        return False
    signs = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)]
    return all(s > 0 for s in signs) or all(s < 0 for s in signs)


def crosses_itself(vertices, triangles):
    boxes = []
    for i, t in enumerate(triangles):
        points = [vertices[v] for v in t]
        boxes.append(([min(p[k] for p in points) for k in range(3)], [max(p[k] for p in points) for k in range(3)], i))
    boxes.sort(key=lambda box: box[0][0])
    for place, (low, high, i) in enumerate(boxes):
        for other_low, other_high, j in boxes[place + 1:]:
            if other_low[0] > high[0]:
                break
            if any(other_low[k] > high[k] or low[k] > other_high[k] for k in (1, 2)):
                continue
            for one, two in ((triangles[i], triangles[j]), (triangles[j], triangles[i])):
                solid = [vertices[v] for v in two]
                for k in range(3):
                    ends = one[k], one[(k + 1) % 3]
                    if set(ends) & set(two):
                        continue
                    if pierces(vertices[ends[0]], vertices[ends[1]], solid):
                        return True
    return False


def is_folded(vertices, triangles):
    """Whether two neighbours lie on one another, as those of a flat side do that is turned over."""
    normals = {}
    for t in triangles:
        a, b, c = (vertices[v] for v in t)
        u = [b[k] - a[k] for k in range(3)]
        v = [c[k] - a[k] for k in range(3)]
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        size = sum(x * x for x in n) ** 0.5 or 1.0
        for k in range(3):
            normals.setdefault(frozenset((t[k], t[(k + 1) % 3])), []).append([x / size for x in n])
    return any(sum(x * y for x, y in zip(*pair)) < -1.0 + 1e-6 for pair in normals.values())


def calc_volume(vertices, triangles):
    total = 0.0
    for t in triangles:
        a, b, c = (vertices[v] for v in t)
        total += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                  + a[2] * (b[0] * c[1] - b[1] * c[0]))
    return total / 6.0


def check_refusal(document, meshes, values, initial):
    refused = [b["body"] for b in document["bodies"] if any(f["error"] for f in b["findings"])]
    for body in refused:
        mesh, triangles = meshes[body]
        vertices = mesh.at(values, initial)
        if calc_volume(vertices, triangles) <= 0.0 or is_folded(vertices, triangles):
            continue
        if not crosses_itself(vertices, triangles):
            fail(f"{document['scenario']}: {body} at {document['theta']} was refused, and is a body: "
                 f"{document['bodies']}")


# ---- All of it ----------------------------------------------------------------------------------------------------


def check_config(knap, config, count, sliced, folder):
    parameters = list_parameters(knap, config)
    initial = [p[1] for p in parameters]
    draw = random.Random(1)
    designs = [initial, [p[2] for p in parameters], [p[3] for p in parameters]]
    designs += [[draw.uniform(p[2], p[3]) for p in parameters] for _ in range(count)]
    refusals, judged, layers, linear = 0, 0, 0, None
    for number, values in enumerate(designs):
        files = {}
        document = None
        for ending in ("stl", "3mf"):
            document = export(knap, config, parameters, values, os.path.join(folder, "tool." + ending))
            for body in document["bodies"]:
                if body["file"]:
                    files[body["file"]] = body
        if not document["written"]:
            refusals += 1
            if linear is None:
                linear = make_linear_meshes(knap, config, parameters, folder)
            if linear is None:
                fail(f"{config}: no mesh to judge refusals by")
            check_refusal(document, linear, values, initial)
            continue
        infos = ask_slicer(list(files))
        for file, body in files.items():
            check_slicer(body, file, infos.get(os.path.basename(file)) or infos.get(file))
            judged += 1
            if file.endswith(".stl"):
                check_admesh(file)
        if number < sliced:
            for file in files:
                if file.endswith(".3mf"):
                    layers += check_slicing(file, folder)
        for file in files:
            os.remove(file)
    print(f"{config}: {len(designs)} designs, {judged} files manifold, {refusals} refused and rightly so"
          f"{f', {layers} layers sliced' if sliced else ''}", flush=True)


def main():
    knap, count, sliced, configs = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]
    for program, package in (("prusa-slicer", "prusa-slicer"), ("admesh", "admesh")):
        if shutil.which(program) is None:
            print(f"SKIPPED: {program} is not installed (package {package}); printed tools are not judged")
            sys.exit(77)
    for config in configs:
        with tempfile.TemporaryDirectory() as folder:
            check_config(knap, config, count, sliced, folder)


main()
