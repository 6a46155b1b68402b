#!/usr/bin/env python3
"""Writes pusher_path.csv: the zig-zag of pushing.yaml, fading before the scoop, which comes to rest at its opening."""
import math

AMPLITUDE, PERIOD, SHARPNESS, SPEED, STOP = 22.0, 3.0, 0.95, 60.0, 370.0  # [mm], [s], [-], [mm/s], [mm]
FADES, FADED = 270.0, 330.0  # where along y the swing begins to fade and has faded [mm]
BRAKE = 10.0  # the last way, over which the speed falls evenly [mm]
ROW = 0.05  # [s]


def smooth(s):
    s = min(max(s, 0.0), 1.0)
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)


def forward(t):
    begin = (STOP - BRAKE) / SPEED
    if t <= begin:
        return SPEED * t
    last = min(t - begin, 2.0 * BRAKE / SPEED)
    return STOP - BRAKE + SPEED * last - SPEED * SPEED / (4.0 * BRAKE) * last * last


def sideways(t):
    swing = math.asin(SHARPNESS * math.sin(2.0 * math.pi * t / PERIOD)) / math.asin(SHARPNESS)
    return AMPLITUDE * swing * (1.0 - smooth((forward(t) - FADES) / (FADED - FADES)))


with open("pusher_path.csv", "w", encoding="ascii") as out:
    out.write("time,x,y,z,roll,pitch,yaw\n")
    for i in range(round(7.0 / ROW) + 1):
        t = i * ROW
        out.write(f"{t:.2f},{1e-3 * sideways(t):.9f},{1e-3 * forward(t):.9f},0,0,0,0\n")
