// What drives the actuators of a scene (scene.h): open-loop controls, or a closed-loop policy. Both give an actuator a
// command, held for an interval; what a command of 1 means is the actuator's business (joint.h).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "sim/scenarios/axis.h"

namespace knap {

enum class Squash { kTanh, kNone };

// Open-loop controls: one number a for each interval and actuator, held all through the interval. The actuator gets
// the command u = tanh(a), or a itself, which then lies in [−1, 1] (control_commands.h).
struct Controls {
  std::vector<std::string> actuators;  // bodies whose joints are driven, in the order of their values in each interval
  double interval = 0.0;               // [s]; a whole number of steps, and the horizon a whole number of intervals
  Squash squash = Squash::kTanh;
  double initial = 0.0;  // of every a [-]; lower ≤ initial ≤ upper, lower < upper
  double lower = -3.0;
  double upper = 3.0;
};

// ---- Observations: what a policy sees, one number each: (what is observed − offset)/scale
// -----------------------------

// Of the joint of body `joint`, which is revolute …
struct AngleObservation {
  std::string joint;
  double offset = 0.0;  // [rad]
  double scale = 1.0;   // [rad], > 0; likewise below
};

struct RateObservation {
  std::string joint;
  double offset = 0.0;  // [rad/s]
  double scale = 1.0;
};

// … or prismatic.
struct DisplacementObservation {
  std::string joint;
  double offset = 0.0;  // [m]
  double scale = 1.0;
};

struct SpeedObservation {
  std::string joint;
  double offset = 0.0;  // [m/s]
  double scale = 1.0;
};

// Coordinate `axis` of a body's point in the frame of another body, p_AoP_A, or in the world.
struct PositionObservation {
  std::string body;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // in B [m]; moves with the mesh of a designed body
  std::string in = "world";
  Axis axis = Axis::kX;
  double offset = 0.0;  // [m]
  double scale = 1.0;
};

// Component of v_WP_W.
struct VelocityObservation {
  std::string body;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // as above
  Axis axis = Axis::kX;
  double offset = 0.0;  // [m/s]
  double scale = 1.0;
};

// Component `axis` in the frame of another body of the unit vector along the body's own axis `of`: an entry of R_AB.
struct DirectionObservation {
  std::string body;
  Axis of = Axis::kX;
  std::string in = "world";
  Axis axis = Axis::kX;
  double offset = 0.0;  // [-]
  double scale = 1.0;
};

// Component of w_WB_W.
struct AngularVelocityObservation {
  std::string body;
  Axis axis = Axis::kX;
  double offset = 0.0;  // [rad/s]
  double scale = 1.0;
};

struct TimeObservation {
  double offset = 0.0;  // [s]
  double scale = 1.0;
};

// A number of the scene that may vary: a goal, a mass.
struct NumberObservation {
  std::string key;      // as in Variation
  double offset = 0.0;  // in the SI unit of the key
  double scale = 1.0;
};

using PolicyObservation = std::variant<AngleObservation, RateObservation, DisplacementObservation, SpeedObservation,
                                       PositionObservation, VelocityObservation, DirectionObservation,
                                       AngularVelocityObservation, TimeObservation, NumberObservation>;

// ---- Policy ---------------------------------------------------------------------------------------------------------

// Weights of a unit with n inputs: normal with standard deviation scale/√n, truncated at three of them and at the
// bounds; biases 0.
struct RandomWeights {
  std::int64_t seed = 0;
  double scale = 1.0;  // [-]
};

// sim/policy/weights_file.h
struct WeightsFile {
  std::string file;  // relative to the scenario's
};

using InitialWeights = std::variant<RandomWeights, WeightsFile>;

// A feed-forward network with tanh units from observations to commands (sim/policy/network.h), asked at the start of
// each interval.
struct Policy {
  std::vector<std::string> actuators;  // bodies whose joints it drives, in the order of its outputs
  double interval = 0.0;               // as for Controls
  std::vector<PolicyObservation> observations;
  std::vector<std::int64_t> hidden;  // units of each hidden layer
  Squash squash = Squash::kTanh;     // of the outputs
  InitialWeights initial;
  double lower = -3.0;  // of every weight [-], < upper
  double upper = 3.0;
};

}  // namespace knap
