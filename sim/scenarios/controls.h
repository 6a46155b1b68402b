// What drives the actuators of a scene (scene.h): open-loop controls, or a closed-loop policy. Both give an actuator a
// command, held for an interval; what a command of 1 means is the actuator's business (joint.h).
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

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

// (signal − offset)/scale: what the policy sees of the state, one number.
struct Observation {
  std::string signal;
  double offset = 0.0;  // in the signal's unit
  double scale = 1.0;   // likewise, > 0
};

// A feed-forward network with tanh units from observations to commands (sim/policy/network.h), asked at the start of
// each interval.
struct Policy {
  std::vector<std::string> actuators;  // bodies whose joints it drives, in the order of its outputs
  double interval = 0.0;               // as for Controls
  std::vector<Observation> observations;
  std::vector<std::int64_t> hidden;  // units of each hidden layer
  Squash squash = Squash::kTanh;     // of the outputs
  InitialWeights initial;
  double lower = -3.0;  // of every weight [-], < upper
  double upper = 3.0;
};

}  // namespace knap
