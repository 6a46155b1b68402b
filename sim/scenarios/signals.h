// Signals: one number of the state at a time, known by a name in the scenario file. Losses, success, observations of
// policies, exported trajectories and plots all speak of signals; nothing else looks at the state.
//
// A kind of signal is a struct here, its fields in signal_fields.cc, and its evaluation in sim/signals;
// docs/extending.md shows where a new one goes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>
#include <vector>

#include "sim/scenarios/axis.h"

namespace knap {

// ---- Joints -------------------------------------------------------------------------------------------------------

// Of the revolute joint of body `joint` [rad], [rad/s] …
struct AngleSignal {
  std::string joint;
};
struct RateSignal {
  std::string joint;
};

// … or of its prismatic one [m], [m/s].
struct DisplacementSignal {
  std::string joint;
};
struct SpeedSignal {
  std::string joint;
};

// ---- Bodies -------------------------------------------------------------------------------------------------------

// Coordinate `axis` of a body's point in the frame of another body, p_AoP_A, or in the world [m].
struct PositionSignal {
  std::string body;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // in B [m]; moves with the mesh of a designed body
  std::string in = "world";
  Axis axis = Axis::kX;
};

// Component of v_WP_W [m/s].
struct VelocitySignal {
  std::string body;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // as above
  Axis axis = Axis::kX;
};

// Component `axis` in the frame of another body of the unit vector along the body's own axis `of`: an entry of R_AB.
struct DirectionSignal {
  std::string body;
  Axis of = Axis::kX;
  std::string in = "world";
  Axis axis = Axis::kX;
};

// Component of w_WB_W [rad/s].
struct AngularVelocitySignal {
  std::string body;
  Axis axis = Axis::kX;
};

struct TimedPosition {
  double after = 0.0;                                  // time after which it counts; the first one always does [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // in the frame A [m]
};

// ‖p_AoP_A − target‖ of a body's point from a place in the frame of another body, or in the world, that may change with
// time [m].
struct DistanceSignal {
  std::string body;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // as above
  std::string in = "world";
  std::vector<TimedPosition> targets;  // ascending, at least one
};

// ---- Groups: bodies and ropes, by their common centre of mass C -----------------------------------------------------

// Coordinate of p_AoC_A, or in the world [m].
struct CenterOfMassSignal {
  std::vector<std::string> of;
  std::string in = "world";
  Axis axis = Axis::kX;
};

// −ĝ·p_WoC_W, ĝ the direction of gravity [m].
struct HeightSignal {
  std::vector<std::string> of;
};

// How much higher C is than if a body had carried it along since a time s: −ĝ·(p_WoC(t) − X_WA(t) X_WA(s)⁻¹ p_WoC(s))
// [m]. Where the world carries it, that is the change of its height.
struct DriftSignal {
  std::vector<std::string> of;
  std::string carried_by = "world";
  double since = 0.0;  // [s], a whole number of steps
};

// ---- Contacts -----------------------------------------------------------------------------------------------------

// Of two bodies or ropes that have a contact: the depth of the deepest place [m], the size of the whole force [N].
struct DepthSignal {
  std::array<std::string, 2> bodies;
};
struct ForceSignal {
  std::array<std::string, 2> bodies;
};

// ---- The design's shape, which stays as it is during a rollout ------------------------------------------------------
// Of a designed body: shape_measures.h tells what they are.

struct VolumeSignal {
  std::string body;  // [m³]
};
struct ExtentSignal {
  std::string body;  // [m]
  Axis axis = Axis::kX;
};
struct ThicknessSignal {
  std::string body;       // [m]
  double blend = 0.2e-3;  // [m]
};

// ---- Commands -----------------------------------------------------------------------------------------------------

// The command of an actuator in the interval that leads to the time, from −1 to 1 [-].
struct CommandSignal {
  std::string actuator;
};

// ---- Neither ------------------------------------------------------------------------------------------------------

struct TimeSignal {};  // [s]

// A number of the scene that may vary: a goal, a mass. It has no time.
struct NumberSignal {
  std::string key;  // as in Variation
};

// ---- Of other signals, which stand before it and have one dimension -----------------------------------------------

struct DifferenceSignal {
  std::vector<std::string> of;  // two: the first less the second
};
struct NormSignal {
  std::vector<std::string> of;  // √Σ s²
};
struct LeastSignal {
  std::vector<std::string> of;
};
struct LargestSignal {
  std::vector<std::string> of;
};

using SignalKind =
    std::variant<AngleSignal, RateSignal, DisplacementSignal, SpeedSignal, PositionSignal, VelocitySignal,
                 DirectionSignal, AngularVelocitySignal, DistanceSignal, CenterOfMassSignal, HeightSignal, DriftSignal,
                 DepthSignal, ForceSignal, VolumeSignal, ExtentSignal, ThicknessSignal, CommandSignal, TimeSignal,
                 NumberSignal, DifferenceSignal, NormSignal, LeastSignal, LargestSignal>;

struct Signal {
  std::string name;
  SignalKind kind;
};

}  // namespace knap
