// What is to be learned, as far as the coordinator needs to know: bounded, named parameters and the distribution of the
// task variations. What the numbers mean is the workers' business.
#pragma once

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

struct UniformDraw {
  double lower = 0.0, upper = 0.0;  // lower <= upper; equal bounds give that value always
};

// Conditioned on |x - mean| <= truncate_at · standard_deviation; infinity: not truncated.
struct NormalDraw {
  double mean = 0.0, standard_deviation = 1.0;                   // standard_deviation >= 0
  double truncate_at = std::numeric_limits<double>::infinity();  // > 0 [-]
};

// One varied number of the scenario: a start coordinate, a physical parameter, a goal. In the key's own SI unit.
struct VariationKey {
  std::string name;
  std::variant<UniformDraw, NormalDraw> distribution;
};

using VariationSpec = std::vector<VariationKey>;  // names differ; no keys: all rollouts start alike

struct Problem {
  ParameterSpec parameters;
  VariationSpec variations;
};

// Throws std::invalid_argument with the name of the field, its value and what is allowed.
void CheckProblem(const Problem& problem);

// The values of variation `index` of a stream, one for each key in the order of `spec`. A pure function of its
// arguments: variation i is the same whatever other variations are drawn. Keys are independent; a uniform and a normal
// key each consume one 64-bit draw.
std::vector<double> SampleVariation(const VariationSpec& spec, std::uint64_t seed, RandomStream stream,
                                    std::uint64_t index);

// Design `index` of the stream kRandomThetas: uniform within the bounds.
std::vector<double> SampleTheta(const ParameterSpec& spec, std::uint64_t seed, std::uint64_t index);

}  // namespace knap
