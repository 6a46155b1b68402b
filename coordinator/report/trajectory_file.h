// A recorded rollout as a file for other programs: CSV or JSON, SI units, all in the world's frame.
//
// CSV: one row a recorded time, `time` first, then
//   BODY.x BODY.y BODY.z              place of its origin [m]
//   BODY.qw BODY.qx BODY.qy BODY.qz   its orientation, a unit quaternion that turns the body's axes into the world's
//   BODY.joint                        coordinate of the revolute or prismatic joint that moves it [rad or m]
//   signal.NAME                       of the scenario, in its SI unit; of a rollout that converged
//   A|B.fx A|B.fy A|B.fz              contact force on A from B [N], zero while they do not touch
//   A|B.px A|B.py A|B.pz              where it acts [m], empty while they do not touch
//   A|B.depth                         of the deepest place [m]
// for all bodies in the order of the scenario, the links of ropes as "ROPE link I", and all pairs that touch at some
// time. JSON has the same numbers, null in place of an empty field.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sim/rollout/recording.h"

namespace knap {

std::string FormatTrajectoryCsv(const Recording& recording);
nlohmann::ordered_json MakeTrajectoryJson(const Recording& recording);

}  // namespace knap
