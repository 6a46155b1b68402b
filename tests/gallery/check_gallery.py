#!/usr/bin/env python3
"""check_gallery.py KNAP GALLERY

Judges rollouts of the gallery's tasks, and of the scoop beside it, by their exported trajectories alone: what is a
success by places of bodies in the CSV must be one for knap, and the other way round; with designs as learning finds
them, and with the initial ones.
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile


def rows_of(path):
    with open(path, newline="") as file:
        return [{name: float(text) for name, text in row.items() if text} for row in csv.DictReader(file)]


def distance(row, body, place):
    return sum((row[f"{body}.{axis}"] - p) ** 2 for axis, p in zip("xyz", place)) ** 0.5


def sweeps_into_the_disc(rows):
    return distance(rows[-1], "cube", (0, 0.170, 0.010)) < 0.013


def gathers_three_balls(rows):
    end = rows[-1]
    place = (end["rake.x"], end["rake.y"] + 0.015, end["rake.z"] + 0.007)  # the rake does not turn
    return all(distance(end, ball, place) < 0.020 for ball in ("left", "middle", "right"))


def presses_the_button(rows):
    """Lower than 4 mm below where it stands unpressed, for a tenth of a second without a break."""
    since = None
    for row in rows:
        if row["cap.z"] - 0.005 >= -0.004:
            since = None
            continue
        since = row["time"] if since is None else since
        if row["time"] - since >= 0.1 - 1e-9:
            return True
    return False


def falls_through_the_hole(rows):
    """Where the ball first passes 30 mm below the ring, between the rows before and after by a straight line."""
    for before, after in zip(rows, rows[1:]):
        if before["ball.z"] >= -0.030 > after["ball.z"]:
            share = (before["ball.z"] + 0.030) / (before["ball.z"] - after["ball.z"])
            x, y = (before[f"ball.{axis}"] + share * (after[f"ball.{axis}"] - before[f"ball.{axis}"]) for axis in "xy")
            return (x * x + y * y) ** 0.5 < 0.012
    return False


def lifts_the_coin_whole(rows):
    """25 mm high at the end, and never pressed into by more than 0.7 mm."""
    return rows[-1]["coin.z"] > 0.025 and all(row.get("coin|pan.depth", 0) < 0.0007 for row in rows)


def hangs_the_ring_up(rows):
    return rows[-1]["ring.z"] > 0.072


def lies_in_the_scoop(rows):
    """Between its walls and its back at the end, and pusher and scoop never met by half a millimetre."""
    end = rows[-1]
    return (abs(end["pea.x"]) < 0.013 and 0.372 < end["pea.y"] < 0.417
            and all(row.get("pusher|scoop.depth", 0) < 0.0005 for row in rows))


TASKS = {
    "sweep": (sweeps_into_the_disc, 4, "left_tip=32 mm,left_middle=16 mm,right_middle=16 mm,right_tip=32 mm"),
    "rake": (gathers_three_balls, 4, "left_tip=34 mm,left_middle=4 mm,right_middle=4 mm,right_tip=34 mm"),
    "arm_sweep": (sweeps_into_the_disc, 2, "left_tip=32 mm,left_middle=16 mm,right_middle=16 mm,right_tip=32 mm"),
    "funnel": (falls_through_the_hole, 6, "east=4 mm,north=4 mm,west=4 mm,south=4 mm"),
    "coin": (lifts_the_coin_whole, 3, "lip=-1 mm,floor=-2 mm,heel=-2 mm,back=-4 mm"),
    "hook": (hangs_the_ring_up, 3, "tip=12.7 mm,bend=6.4 mm,shaft=2 mm"),
    "../pushing_scoop": (lies_in_the_scoop, 5, "middle_width=37.6 mm,left_wing_width=30.7 mm,right_wing_width=31.6 mm,"
                         "left_depth=10.3 mm,right_depth=12.8 mm,left_bow=2 mm,right_bow=2.8 mm"),
    "button": (presses_the_button, 0, "length=54.5 mm"),
}


def imports_the_same_arm(knap, gallery):
    """The arm beside arm_sweep.yaml is what `knap import` makes of its URDF, to the byte."""
    robots = (gallery / "robots").resolve()
    with tempfile.TemporaryDirectory() as folder:
        command = [knap, "import", str(robots / "seven_joints.urdf"), "--follow", "sweep_path.csv"]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        return (pathlib.Path(folder) / "seven_joints.yaml").read_text() == (robots / "seven_joints.yaml").read_text()


def main():
    knap, gallery = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2])
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "motion.csv"
        for task, (judge, variations, learned) in TASKS.items():
            successes = {}
            for design in ("initial", learned):
                for variation in range(max(variations, 1)):
                    chosen = ["--variation", str(variation)] if variations else []
                    answer = json.loads(subprocess.run(
                        [knap, "rollout", gallery / f"{task}.yaml", "--theta", design, *chosen, "--trajectory", file,
                         "--json"], check=True, capture_output=True, text=True).stdout)
                    own = judge(rows_of(file))
                    successes.setdefault(design, []).append(own)
                    if own != answer["success"]:
                        print(f"{task}, {design}, variation {variation}: the trajectory says {own}, "
                              f"knap {answer['success']}")
                        wrong += 1
            print(task, {design: f"{sum(seen)} of {len(seen)}" for design, seen in successes.items()})
            if not all(successes[learned]) or all(successes["initial"]):
                print(f"{task}: the learned design is to succeed, and the initial one to fail at times")
                wrong += 1
    if not imports_the_same_arm(knap, gallery):
        print("robots/seven_joints.yaml is not what `knap import` makes of seven_joints.urdf")
        wrong += 1
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
