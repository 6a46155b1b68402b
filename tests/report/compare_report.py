#!/usr/bin/env python3
"""compare_report.py REPORT.html LEARNED.csv

Holds a report against what other commands write of the same run: DESIGN-VARIATION.csv in the working directory, from
`knap rollout --trajectory`, and LEARNED.csv, from `knap evaluate --csv`. Prints what differs and exits with 1.
"""

import base64
import csv
import glob
import json
import re
import struct
import sys


def floats(text):
    data = base64.b64decode(text)
    return struct.unpack(f"<{len(data) // 4}f", data)


def read_table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def compare_trajectory(data, replay, table, fail):
    times = floats(replay["times"])
    poses = floats(replay["poses"])
    moving = [body["name"] for body in data["bodies"] if body["moves"]]
    by_time = {struct.unpack("<f", struct.pack("<f", float(row["time"])))[0]: row for row in table}
    for k, time in enumerate(times):
        row = by_time.get(time)
        if row is None:
            fail(f"time {time} is none of the trajectory's")
            return
        for i, name in enumerate(moving):
            at = poses[7 * (k * len(moving) + i):][:7]
            place = [float(row[f"{name}.{axis}"]) for axis in "xyz"]
            turn = [float(row[f"{name}.q{axis}"]) for axis in "wxyz"]
            sign = 1.0 if sum(a * b for a, b in zip(at[3:], turn)) > 0 else -1.0
            error = max(abs(a - b) for a, b in zip(at, place + [sign * x for x in turn]))
            if error > 1e-6:
                fail(f"{name} at {time} s is off by {error}")
                return
    forces = {"|".join(force["between"]): floats(force["force"]) for force in replay["forces"]}
    if not forces:
        fail("nothing touches anything")
    for pair, series in forces.items():
        for k, time in enumerate(times):
            given = [float(by_time[time][f"{pair}.f{axis}"]) for axis in "xyz"]
            if max(abs(a - b) for a, b in zip(series[3 * k:], given)) > 1e-6 * (1.0 + max(map(abs, given))):
                fail(f"the force of {pair} at {time} s differs")
                return


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        page = file.read()
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S).group(1))
    failures = []
    replays = {(replay["design"], replay["variation"]): replay for replay in data["replays"]}
    if len(replays) != 24:
        failures.append(f"{len(replays)} replays of 12 variations and 2 designs")
    for key, replay in replays.items():
        if replay["same_bits"] is not True:
            failures.append(f"{key}: not the bits of the run")
    compared = 0
    for path in glob.glob("*-*.csv"):
        design, variation = path[:-4].split("-")
        key = (design, int(variation))
        problems = []
        compare_trajectory(data, replays[key], read_table(path), problems.append)
        failures += [f"{key}: {problem}" for problem in problems]
        compared += 1
    if compared != 4:
        failures.append(f"{compared} trajectories to compare with")
    learned = data["variation"]["learned"]
    rows = read_table(sys.argv[2])
    if [float(row["loss"]) for row in rows] != learned["loss"]:
        failures.append("evaluate --csv has other losses")
    if data["has_success"]:
        if [int(row["success"]) for row in rows] != learned["success"]:
            failures.append("evaluate --csv has other successes")
        rate = sum(learned["success"]) / len(rows)
        if abs(rate - data["test"]["learned"]["success_rate"]) > 1e-12:
            failures.append("the summary has another success rate")
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
