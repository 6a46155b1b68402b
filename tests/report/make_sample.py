#!/usr/bin/env python3
"""make_sample.py pushing|rope|bare [SEED]

Writes on standard output the data of a made-up run, as `knap report` gives it to its page. The motions follow simple
kinematics: they look like the real ones and are none. `pushing` has a designed mesh with a basis, successes and a
variation of two keys; `rope` has many links, a fixed designed body without a basis, one key, no success and rollouts
that failed; `bare` has only what every run has.
"""

import base64
import json
import math
import random
import struct
import sys


def pack(values):
    return base64.b64encode(struct.pack(f"<{len(values)}f", *values)).decode()


def pack_integers(values):
    return base64.b64encode(struct.pack(f"<{len(values)}I", *values)).decode()


def about_z(angle):
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def from_z_to(direction):
    """The quaternion that turns z into a direction."""
    length = math.sqrt(sum(x * x for x in direction)) or 1.0
    x, y, z = (c / length for c in direction)
    w = 1 + z
    if w < 1e-9:
        return [0.0, 1.0, 0.0, 0.0]
    norm = math.sqrt(w * w + x * x + y * y)
    return [w / norm, -y / norm, x / norm, 0.0]


def digest(random_source):
    return "".join(random_source.choice("0123456789abcdef") for _ in range(64))


def summary(losses, successes, distrust):
    known = [loss for loss in losses if loss is not None]
    mean = sum(known) / len(known)
    deviation = math.sqrt(sum((loss - mean) ** 2 for loss in known) / len(known))
    half = 1.96 * deviation / math.sqrt(len(known))
    worst = sorted(known)[-max(1, len(known) // 10):]
    reasons = {}
    for reason in distrust:
        if reason:
            reasons[reason] = reasons.get(reason, 0) + 1
    rate = interval = None
    if successes is not None:
        n, z = len(successes), 1.96
        rate = sum(successes) / n
        middle = (rate + z * z / (2 * n)) / (1 + z * z / n)
        width = z * math.sqrt(rate * (1 - rate) / n + z * z / (4 * n * n)) / (1 + z * z / n)
        interval = [middle - width, min(1.0, middle + width)]
    return {
        "loss_mean": mean, "loss_mean_95": [mean - half, mean + half], "loss_std": deviation, "success_rate": rate,
        "success_rate_95": interval, "worst_decile_loss": sum(worst) / len(worst),
        "not_converged": len(losses) - len(known), "not_finite": 0,
        "untrusted": sum(1 for reason in distrust if reason), "distrust": reasons,
    }


# --- Pushing -------------------------------------------------------------------------------------------------------

PARAMETERS = ["middle_width", "left_wing_width", "right_wing_width", "left_depth", "right_depth", "left_bow",
              "right_bow"]
LOWER = [0.030, 0.020, 0.020, -0.015, -0.015, -0.005, -0.005]
UPPER = [0.050, 0.032, 0.032, 0.040, 0.040, 0.005, 0.005]
INITIAL = [0.044, 0.030, 0.030, 0.0, 0.0, 0.0, 0.0]
LEARNED = [0.0361, 0.0317, 0.0312, 0.0272, 0.0251, -0.0031, -0.0026]
PEA_RADIUS = 0.007


def face(theta, s):
    """The pusher's front at s from -1 (left tip) to 1 (right tip): x and y."""
    middle, wing, depth, bow = (theta[0], theta[1], theta[3], theta[5]) if s < 0 else (
        theta[0], theta[2], theta[4], theta[6])
    share = max(0.0, (abs(s) - 0.4) / 0.6)
    x = math.copysign(min(abs(s) / 0.4, 1.0) * middle / 2 + share * wing, s)
    return x, depth * share + 4 * bow * share * (1 - share)


def pusher_vertices(theta, stations=24):
    vertices = []
    for i in range(stations + 1):
        x, y = face(theta, 2 * i / stations - 1)
        vertices += [x, y - 0.008, 0.0, x, y, 0.0, x, y, 0.018, x, y - 0.008, 0.018]
    return vertices


def pusher_triangles(stations=24):
    triangles = []
    for i in range(stations):
        a, b = 4 * i, 4 * (i + 1)
        for k in range(4):
            n = (k + 1) % 4
            triangles += [a + k, b + k, b + n, a + k, b + n, a + n]
    end = 4 * stations
    triangles += [0, 1, 2, 0, 2, 3, end, end + 2, end + 1, end, end + 3, end + 2]
    # The stations' corners run against the clock as seen from +x, so that the bands look inwards as listed.
    return [triangles[i + k] for i in range(0, len(triangles), 3) for k in (0, 2, 1)]


def pusher_basis():
    basis, start = [], pusher_vertices(INITIAL)
    for k in range(len(PARAMETERS)):
        theta = list(INITIAL)
        theta[k] += 1e-3
        basis += [(b - a) / 1e-3 for a, b in zip(start, pusher_vertices(theta))]
    return basis


def front_at(theta, x):
    """Height of the pusher's front and its slope at x; None beyond the tips."""
    points = [face(theta, i / 40 - 1) for i in range(81)]
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x0 <= x <= x1 and x1 > x0:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0), (y1 - y0) / (x1 - x0)
    return None


def push(theta, start):
    """Times, poses of pusher and pea, forces on the pea, and where the pea crosses the line of the opening."""
    x, y = start
    step, times, poses, force, at, offset, crossed = 0.02, [], [], [], [], [], None
    turned = 0.0
    for i in range(336):
        t = i * step
        px, py = 0.022 * math.sin(2 * math.pi * t / 3), min(0.06 * t, 0.37)
        front = front_at(theta, x - px)
        touching = front is not None and y - PEA_RADIUS < py + front[0] and y > py - 0.01
        if touching:
            turned += (py + front[0] + PEA_RADIUS - y) / PEA_RADIUS
            y = py + front[0] + PEA_RADIUS
            x -= 0.011 * front[1] * step / 0.2 + 0.05 * step * math.copysign(min(1.0, abs(x - px) / 0.03), x - px) * (
                1 if abs(front[1]) > 0.15 else -0.25)
            size = 0.004 * (1 + 0.3 * math.sin(9 * t))
            force += [-front[1] * size, size, 0.0]
            at += [x, y - PEA_RADIUS, PEA_RADIUS]
        else:
            force += [0.0, 0.0, 0.0]
            at += [math.nan] * 3
        if crossed is None and y >= 0.37:
            crossed = x
        times.append(t)
        poses += [px, py, 0.0, 1.0, 0.0, 0.0, 0.0]
        poses += [x, y, PEA_RADIUS, math.cos(turned / 2), -math.sin(turned / 2), 0.0, 0.0]
        offset.append(x)
    return times, poses, force, at, offset, crossed


def pushing(seed):
    source = random.Random(seed)
    values = [[source.uniform(-0.042, 0.042), source.uniform(0.08, 0.12)] for _ in range(200)]
    designs = {"initial": INITIAL, "learned": LEARNED}
    runs = {name: [push(theta, start) for start in values] for name, theta in designs.items()}
    variation = {"keys": [
        {"key": f"bodies.pea.initial.position[{k}]", "unit": "m", "lower": low, "upper": high}
        for k, low, high in ((0, -0.042, 0.042), (1, 0.08, 0.12))], "values": values}
    for name, outcomes in runs.items():
        crossed = [outcome[5] for outcome in outcomes]
        variation[name] = {
            "loss": [0.0024 if x is None else max(0.0, abs(x) - 0.002) ** 2 + 1e-8 for x in crossed],
            "success": [int(x is not None and abs(x) < 0.008) for x in crossed],
            "distrust": ["contact deeper than half of the pea" if name == "initial" and i % 67 == 3 else ""
                         for i in range(len(values))],
            "gradient_reliable": [int(i % 40 != 7) for i in range(len(values))],
        }
    worst = sorted(range(200), key=lambda i: -variation["learned"]["loss"][i])
    replays = [push_replay(source, name, row, runs[name][row], variation[name])
               for row in worst[:4] + [worst[60], worst[120], worst[-1]] for name in designs]
    return {
        **run_part("pushing", "A pusher with a learned shape brings a pea through an opening", True, seed),
        "test": {"variations": 200, "seed": 1, **{
            name: summary(part["loss"], part["success"], part["distrust"])
            for name, part in variation.items() if name in designs}},
        "theta": {"names": PARAMETERS, "kinds": ["m"] * 7, "lower": LOWER, "upper": UPPER, "initial": INITIAL,
                  "learned": LEARNED},
        "variation": variation, "gravity": [0, 0, -9.81],
        "bodies": [
            {"name": "table", "moves": False, "shapes": [{"type": "half_space"}]},
            {"name": "pusher", "moves": True, "shapes": [{
                "type": "mesh", "designed": True, "triangles": pack_integers(pusher_triangles()),
                "vertices": {name: pack(pusher_vertices(theta)) for name, theta in designs.items()},
                "basis": pack(pusher_basis())}]},
            {"name": "pea", "moves": True, "shapes": [{"type": "sphere", "radius": PEA_RADIUS}]}],
        "fixed_poses": {"table": [0, 0, 0, 1, 0, 0, 0]},
        "replays": replays, "learning": learning(source, INITIAL, LEARNED), "timeline": timeline(source),
        "certificates": {"gradients_flagged": 3, "gradients": 1180, "untrusted": 4, "rollouts": 1580, "deepest": 0.083,
                         "largest_force": 0.21},
    }


def push_replay(source, name, row, outcome, results):
    times, poses, force, at, offset, _ = outcome
    reason = results["distrust"][row]
    return {
        "design": name, "variation": row, "id": digest(source), "loss": results["loss"][row],
        "success": bool(results["success"][row]), "distrust": [reason] if reason else [], "doubts": [],
        "times": pack(times), "poses": pack(poses),
        "forces": [{"between": ["pea", "pusher"], "force": pack(force), "at": pack(at)}],
        "signals": [{"name": "pea across the opening", "unit": "m", "values": pack(offset)}],
    }


# --- Rope ----------------------------------------------------------------------------------------------------------

LINKS, LINK = 40, 0.012


def rope_pose(reach, t):
    """Poses of a rope's links that wraps around a rod along y, by `reach` turns at the end."""
    poses, points = [], []
    wrapped = reach * min(1.0, t / 4)
    for i in range(LINKS + 1):
        angle = min(i * LINK / 0.02, 2 * math.pi * wrapped)
        rest = max(0.0, i * LINK - 0.02 * angle)
        points.append([0.02 * math.sin(angle) + rest * math.cos(angle) * 0.9,
                       0.0025 * angle + 0.004 * math.sin(3 * t + i / 4),
                       0.2 + 0.02 * math.cos(angle) - rest * 0.43 - 0.25 * rest * math.sin(angle)])
    for a, b in zip(points, points[1:]):
        poses += [(p + q) / 2 for p, q in zip(a, b)] + from_z_to([q - p for p, q in zip(a, b)])
    return poses, points


def rope_replay(source, name, row, reach, loss):
    times = [0.04 * i for i in range(126)]
    poses = [x for t in times for x in rope_pose(reach, t)[0]]
    forces = []
    for link in range(0, 12, 2):
        force, at = [], []
        for t in times:
            touching = reach * min(1.0, t / 4) * 2 * math.pi * 0.02 > link * LINK
            point = rope_pose(reach, t)[1][link]
            force += [0.02 * point[0] / 0.02, 0.0, 0.02 * (point[2] - 0.2) / 0.02] if touching else [0.0] * 3
            at += point if touching else [math.nan] * 3
        forces.append({"between": [f"link_{link}", "rod"], "force": pack(force), "at": pack(at)})
    tension = [0.3 + 0.1 * math.sin(t) for t in times]
    return {"design": name, "variation": row, "id": digest(source), "loss": loss, "success": None, "distrust": [],
            "doubts": ["link_3 passed a switch of the friction law within 1e-9 m/s"] if row == 2 else [],
            "times": pack(times), "poses": pack(poses), "forces": forces,
            "signals": [{"name": "tension at the grip", "unit": "N", "values": pack(tension)},
                        {"name": "turns", "unit": "", "values": pack([reach * min(1, t / 4) for t in times])}]}


def rod_vertices(flare, stations=16, around=20):
    vertices = []
    for i in range(stations + 1):
        y = 0.12 * i / stations - 0.06
        radius = 0.018 + flare * (y / 0.06) ** 2
        for k in range(around):
            angle = 2 * math.pi * k / around
            vertices += [radius * math.cos(angle), y, 0.2 + radius * math.sin(angle)]
    return vertices + [0.0, -0.06, 0.2, 0.0, 0.06, 0.2]


def rod_triangles(stations=16, around=20):
    triangles, last = [], (stations + 1) * around
    for k in range(around):
        n = (k + 1) % around
        for i in range(stations):
            a, b = i * around, (i + 1) * around
            triangles += [a + k, b + k, b + n, a + k, b + n, a + n]
        triangles += [last, k, n, last + 1, stations * around + n, stations * around + k]
    return triangles


def rope(seed):
    source = random.Random(seed)
    values = [[source.uniform(0.2, 0.6)] for _ in range(60)]
    losses = {"initial": [0.3 + 0.5 * abs(v[0] - 0.3) + 0.02 * source.random() for v in values],
              "learned": [0.02 + 1.8 * (v[0] - 0.4) ** 2 + 0.01 * source.random() for v in values]}
    losses["initial"][5] = losses["learned"][11] = None
    variation = {"keys": [{"key": "contacts[1].friction", "unit": "", "lower": 0.2, "upper": 0.6}], "values": values}
    for name, own in losses.items():
        variation[name] = {"loss": own, "distrust": [""] * 60}
    rows = [2, 11, 30]
    bodies = [{"name": "rod", "moves": False, "shapes": [{
        "type": "mesh", "designed": True, "triangles": pack_integers(rod_triangles()),
        "vertices": {"initial": pack(rod_vertices(0.0)), "learned": pack(rod_vertices(0.012))}}]},
        {"name": "stand", "moves": False, "shapes": [{"type": "box", "size": [0.02, 0.02, 0.2]}]},
        {"name": "floor", "moves": False, "shapes": [{"type": "half_space"}]}]
    bodies += [{"name": f"link_{i}", "moves": True, "shapes": [{"type": "capsule", "radius": 0.003, "length": LINK}]}
               for i in range(LINKS)]
    return {
        **run_part("rope", "A rope is wound around a rod whose flare is learned", False, seed),
        "loss_unit": None,
        "test": {"variations": 60, "seed": 0, **{
            name: summary(own, None, [""] * 60) for name, own in losses.items()}},
        "theta": {"names": ["flare"], "kinds": ["m"], "lower": [-0.005], "upper": [0.015], "initial": [0.0],
                  "learned": [0.012]},
        "variation": variation, "gravity": [0, 0, -9.81], "bodies": bodies,
        "fixed_poses": {"rod": [0, 0, 0, 1, 0, 0, 0], "stand": [0, -0.07, 0.1, *about_z(0.5)],
                        "floor": [0, 0, 0, 1, 0, 0, 0]},
        "replays": [rope_replay(source, name, row, 2.2 if name == "learned" else 1.1, losses[name][row])
                    for row in rows for name in ("initial", "learned")],
        "learning": learning(source, [0.0], [0.012]), "timeline": timeline(source, workers=24),
        "certificates": {"gradients_flagged": 0, "gradients": 300, "untrusted": 0, "rollouts": 420, "deepest": None,
                         "largest_force": 2.4},
    }


# --- What every run has --------------------------------------------------------------------------------------------


def run_part(scenario, description, has_success, seed):
    return {
        "format": 1, "knap": {"version": "1.0.0", "build": "release"},
        "run": {"name": f"{scenario}-sample-{seed}", "scenario": scenario, "description": description, "method": "ours",
                "seed": seed, "host": "bench", "started": "2026-01-02T03:04:05Z", "wall_s": 151.2,
                "rollouts": {"total": 1580, "distinct": 1540, "reissued": 3}, "config_hash": "9f" * 32},
        "loss_unit": "m²", "has_success": has_success,
        "repeat": [f"knap learn configs/{scenario}.yaml --seed {seed} --workers 8",
                   f"knap rollout runs/{scenario}-sample-{seed} --variation 7 --trajectory"],
    }


def learning(source, initial, learned, batches=10, evaluations=12):
    columns = ["time_s", "batch", "loss", "task_loss", "distillation_loss", "gradient_norm", "best_loss", "accepted",
               "successes", "rollouts", "untrusted"]
    table = {name: [] for name in columns}
    rows = []
    for batch in range(1, batches + 1):
        start = 2.2e-3 * math.exp(-0.45 * batch) * source.uniform(0.7, 1.5)
        best = math.inf
        for k in range(evaluations):
            task = start * math.exp(-0.5 * k) * source.uniform(0.8, 1.3)
            distillation = 1e-7 * k * source.uniform(0.5, 1.5) if batch > 1 else 0.0
            best = min(best, task + distillation)
            row = [12.0 * batch + k, batch, task + distillation, task, distillation, 0.3 * math.sqrt(task), best,
                   int(task + distillation == best), min(5, int(k * batch / 8)), 5, 0]
            for name, value in zip(columns, row):
                table[name].append(value)
        share = 1 - math.exp(-0.6 * batch) if batch < batches else 1.0
        rows.append({"batch": batch, "theta": [a + share * (b - a) for a, b in zip(initial, learned)],
                     "start_loss": start, "best_loss": best, "evaluations": evaluations, "stop": "converged",
                     "variations": 5})
    validations = [{"batch": batch, "loss_mean": 2.2e-3 * math.exp(-0.45 * batch) * source.uniform(0.9, 1.1),
                    "success_rate": 1 - 0.8 * math.exp(-0.4 * batch), "best": batch in (0, 1, 3, 7)}
                   for batch in range(batches + 1)]
    return {"evaluations": table, "batches": rows, "validations": validations}


def timeline(source, workers=4):
    names = [f"local-{i + 1}" for i in range(workers)]
    columns = {"worker": [], "kind": [], "end_s": [], "duration_s": [], "attempt": []}
    for worker in range(workers):
        t = 0.3 * source.random()
        while t < 150:
            length = source.uniform(0.4, 1.1)
            lost = worker == 2 and 60 < t < 75
            if not lost:
                kind = "evaluation" if t > 125 else "distillation" if source.random() < 0.3 else "task"
                row = [worker, kind, t + length, length, 2 if source.random() < 0.004 or 75 <= t < 76 else 1]
                for name, value in zip(columns, row):
                    columns[name].append(value)
            t += length + 0.03
    events = [{"time_s": 60.4, "event": "worker_lost", "text": "local-3 was lost; 1 rollout goes to another worker"},
              {"time_s": 75.0, "event": "worker_joined", "text": "local-3 joined again"}]
    return {"workers": names, "rollouts": columns, "events": events}


def bare(seed):
    part = run_part("bare", "A run without a design, a test, or anything recorded", False, seed)
    return {key: part[key] for key in ("format", "knap", "run", "loss_unit", "has_success")}


def study(seed):
    """Three methods with five seeds each; one run of one of them failed altogether."""
    source = random.Random(seed)
    part = run_part("study", "Methods beside each other", True, seed)
    data = {key: part[key] for key in ("format", "knap", "run", "loss_unit", "has_success")}
    data["theta"] = {"names": ["width", "depth"], "kinds": ["m", ""], "lower": [0.01, -1.0], "upper": [0.05, 1.0],
                     "initial": [0.02, 0.0]}
    groups = []
    for method, level in (("ours", 0.95), ("simple_continual", 0.8), ("diffhand", 0.5)):
        runs = []
        for k in range(5):
            failed = method == "diffhand" and k == 4
            rate = min(1.0, level + source.uniform(-0.1, 0.05))
            rollouts = [10 * (i + 1) for i in range(20)]
            losses = [1e-4 * 0.7 ** i for i in range(20)]
            runs.append({
                "name": f"{method}-{k}", "rollouts": 200, "theta": [source.uniform(0.01, 0.05), source.uniform(-1, 1)],
                "test": {"success_rate": 0.0 if failed else rate, "loss_mean": None if failed else 1e-4 * (1 - rate),
                         "worst_decile_loss": None if failed else 1e-3 * (1 - rate)},
                "curve": {"rollouts": rollouts, "best_loss": losses, "validation_loss": losses,
                          "validation_success": [min(rate, 0.2 + 0.05 * i) for i in range(20)]}})
        groups.append({"name": method, "runs": runs})
    data["comparison"] = {"initial": {"success_rate": 0.2, "loss_mean": 3e-4}, "of_runs": False, "groups": groups}
    data["repeat"] = ["knap study study/config.yaml --seeds 5", "knap report study"]
    return data


def main():
    kinds = {"pushing": pushing, "rope": rope, "bare": bare, "study": study}
    if len(sys.argv) < 2 or sys.argv[1] not in kinds:
        sys.exit(__doc__)
    data = kinds[sys.argv[1]](int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    json.dump(data, sys.stdout, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


if __name__ == "__main__":
    main()
