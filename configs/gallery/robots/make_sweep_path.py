#!/usr/bin/env python3
"""make_sweep_path.py > sweep_path.csv

Joint angles of seven_joints.urdf that lead its flange, pointing down 150 mm above the table, along a straight line of
150 mm in 1.5 s, away from the base: a recording as a robot's controller would give it, 20 rows a second.
"""

import math

# Of each joint's frame in the one before: position [m], roll [rad]; the axis is z, that of the last one -z.
JOINTS = [((0, 0, 0.333), 0), ((0, 0, 0), -math.pi / 2), ((0, -0.316, 0), math.pi / 2), ((0.0825, 0, 0), math.pi / 2),
          ((-0.0825, 0.384, 0), -math.pi / 2), ((0, 0, 0), math.pi / 2), ((0.088, 0, 0), math.pi / 2)]
FLANGE = 0.107
START, TRAVEL, HEIGHT = 0.45, 0.15, 0.15
DURATION, RAMP = 1.5, 0.2


def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def turn(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    if axis == "x":
        return [[1, 0, 0], [0, c, -s], [0, s, c]]
    return [[c, -s, 0], [s, c, 0], [0, 0, 1]]


def flange(q):
    """Rotation and position of the flange in the base."""
    R, p = turn("z", 0), [0, 0, 0]
    for i, ((x, y, z), roll) in enumerate(JOINTS):
        p = [p[k] + R[k][0] * x + R[k][1] * y + R[k][2] * z for k in range(3)]
        R = multiply(multiply(R, turn("x", roll)), turn("z", -q[i] if i == 6 else q[i]))
    return R, [p[k] + R[k][2] * FLANGE for k in range(3)]


def miss(q, target):
    """Six numbers that vanish where the flange is at its place."""
    R, p = flange(q)
    R_target, p_target = target
    # The rotation between the two: its angle times its axis.
    E = multiply([list(column) for column in zip(*R_target)], R)
    v = [0.5 * (E[2][1] - E[1][2]), 0.5 * (E[0][2] - E[2][0]), 0.5 * (E[1][0] - E[0][1])]
    sine = math.sqrt(sum(x * x for x in v))
    angle = math.atan2(sine, 0.5 * (E[0][0] + E[1][1] + E[2][2] - 1.0))
    return [p[k] - p_target[k] for k in range(3)] + [x * (angle / sine if sine > 0.0 else 1.0) for x in v]


def solve(A, b):
    n = len(b)
    M = [row[:] + [b[i]] for i, row in enumerate(A)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r: abs(M[r][i]))
        M[i], M[pivot] = M[pivot], M[i]
        for r in range(i + 1, n):
            f = M[r][i] / M[i][i]
            M[r] = [M[r][c] - f * M[i][c] for c in range(n + 1)]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (M[i][n] - sum(M[i][c] * x[c] for c in range(i + 1, n))) / M[i][i]
    return x


def reach(q, target):
    """Newton with the shortest step, dq = Jᵀ (J Jᵀ)⁻¹ (−miss), of at most 0.1 rad a joint."""
    for _ in range(500):
        r = miss(q, target)
        if max(map(abs, r)) < 1e-13:
            return q
        h = 1e-7
        J = []
        for i in range(7):
            up, down = q[:], q[:]
            up[i] += h
            down[i] -= h
            J.append([(a - b) / (2 * h) for a, b in zip(miss(up, target), miss(down, target))])
        JJ = [[sum(J[k][i] * J[k][j] for k in range(7)) for j in range(6)] for i in range(6)]
        y = solve(JJ, [-v for v in r])
        step = [sum(J[k][i] * y[i] for i in range(6)) for k in range(7)]
        scale = min(1.0, 0.1 / max(map(abs, step)))
        q = [q[k] + scale * step[k] for k in range(7)]
    raise SystemExit("the flange cannot be led there")


def share(t):
    """Of the way, with a smooth step of the speed over the ramps."""
    if t >= DURATION:
        return 1.0
    if t > DURATION - RAMP:
        return 1.0 - share(DURATION - t)
    full = 1.0 / (DURATION - RAMP)
    if t >= RAMP:
        return full * (t - 0.5 * RAMP)
    x = t / RAMP
    return full * RAMP * x ** 3 * (1.0 - 0.5 * x)


def main():
    print("time," + ",".join(f"joint{i}" for i in range(1, 8)))
    q = [0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4]
    down = multiply(turn("z", -math.pi / 2), turn("x", math.pi))
    for i in range(31):
        t = 0.05 * i
        q = reach(q, (down, [START + TRAVEL * share(t), 0.0, HEIGHT]))
        print(f"{t:.2f}," + ",".join(f"{angle:.12f}" for angle in q))


if __name__ == "__main__":
    main()
