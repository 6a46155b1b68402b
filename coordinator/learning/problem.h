// What is to be learned, as far as the coordinator needs to know: bounded, named parameters and the distribution of the
// task variations. What the numbers mean is the workers' business.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "coordinator/random/counter_random.h"

namespace knap {

// The vector that is decided on, d of each; SI units. Design parameters come first, then what drives actuators, if
// anything is: open-loop controls and the weights of a policy. `theta` names the whole of it.
struct ParameterSpec {
  std::vector<std::string> names;
  std::vector<double> lower, upper;  // lower_i < upper_i, finite
  std::vector<double> initial;       // lower_i <= initial_i <= upper_i
  std::vector<std::string> units{};  // for people, "" where there is none; no entries: none anywhere
  std::vector<bool> fixed{};         // true: learning leaves it at its initial value; no entries: false everywhere
  std::size_t controls = 0;          // how many of the last ones are controls or weights

  std::string GetUnit(std::size_t i) const { return units.empty() ? "" : units[i]; }
  bool IsFixed(std::size_t i) const { return !fixed.empty() && fixed[i]; }
};

// A parameter's value for people: "left_depth 12.00 mm", "phalanx_0_length 1.25".
std::string FormatParameter(const ParameterSpec& parameters, std::size_t i, double value);

struct UniformDraw {
  double lower = 0.0, upper = 0.0;  // lower <= upper; equal bounds give that value always
};

// Conditioned on |x - mean| <= truncate_at · standard_deviation; infinity: not truncated.
struct NormalDraw {
  double mean = 0.0, standard_deviation = 1.0;                   // standard_deviation >= 0
  double truncate_at = std::numeric_limits<double>::infinity();  // > 0 [-]
};

// The logarithm is uniform; 0 < lower <= upper.
struct LogUniformDraw {
  double lower = 1.0, upper = 1.0;
};

// One of the values, each as likely; at least one.
struct ChoiceDraw {
  std::vector<double> values;
};

// Of several numbers together.

// A point of a ball in as many dimensions as `center` has; radius >= 0.
struct BallDraw {
  std::vector<double> center;
  double radius = 0.0;
};

// Roll, pitch, yaw [rad] of an orientation R = Rz(yaw) Ry(pitch) Rx(roll): uniform over all; or of a turn about `axis`,
// not zero, by an angle uniform on [lower, upper].
struct OrientationDraw {};
struct TurnDraw {
  std::array<double, 3> axis{};
  double lower = 0.0, upper = 0.0;
};

// mean_i + standard_deviation_i Σ_j factor[i][j] z_j with independent truncated normal z; `factor` is the lower
// triangle of the correlations' Cholesky factor. Drawn again until every number lies within truncate_at of its own
// deviations.
struct CorrelatedDraw {
  std::vector<double> mean, standard_deviation;
  std::vector<std::vector<double>> factor;
  double truncate_at = std::numeric_limits<double>::infinity();
};

// One of the rows, each as likely; at least one, all as long as there are names.
struct RowDraw {
  std::vector<std::vector<double>> rows;
};

// Varied numbers of the scenario that are drawn together: a start coordinate, a physical parameter, a place, a goal. In
// the keys' own SI units.
struct VariationKeys {
  std::vector<std::string> names;
  std::variant<UniformDraw, NormalDraw, LogUniformDraw, ChoiceDraw, BallDraw, OrientationDraw, TurnDraw, CorrelatedDraw,
               RowDraw>
      distribution;
};

using VariationSpec = std::vector<VariationKeys>;  // names differ; none: all rollouts start alike

std::vector<std::string> ListNames(const VariationSpec& spec);

// What each number can be, in the order of ListNames; of an unbounded one what nearly all draws are within.
struct DrawRange {
  double lower = 0.0, upper = 0.0;
};
std::vector<DrawRange> ListDrawRanges(const VariationSpec& spec);

struct Problem {
  ParameterSpec parameters;
  VariationSpec variations;
};

// Throws std::invalid_argument with the name of the field, its value and what is allowed.
void CheckProblem(const Problem& problem);

// The values of variation `index` of a stream, one for each name in the order of `spec`. A pure function of its
// arguments, the same on every processor (exact_functions.h): variation i is the same whatever other variations are
// drawn. Entries are independent; a uniform and a normal number each consume one 64-bit draw.
std::vector<double> SampleVariation(const VariationSpec& spec, std::uint64_t seed, RandomStream stream,
                                    std::uint64_t index);

// Design `index` of the stream kRandomThetas: uniform within the bounds.
std::vector<double> SampleTheta(const ParameterSpec& spec, std::uint64_t seed, std::uint64_t index);

}  // namespace knap
