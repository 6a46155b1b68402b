// Which designs a command is to look at, as --theta says it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"

namespace knap {

// Where designs come from that a text does not spell out.
struct NamedDesigns {
  std::string by_default = "initial";                 // "learned" of a run
  std::function<std::vector<double>()> read_learned;  // throws UsageError where there is none
};

// One design: `learned`, or see ParseTheta; an empty text is the default one, whose values are also those of parameters
// that NAME=VALUE,… leaves out.
std::vector<double> ChooseTheta(const std::string& text, const ParameterSpec& parameters, const NamedDesigns& named);

// One theta a design:
//   random:K            K designs, uniform within the bounds, from the stream kRandomThetas of `seed`
//   else                one design, see ChooseTheta
// Values may lie outside the bounds. Throws UsageError naming what is wrong and what is allowed.
std::vector<std::vector<double>> ChooseThetas(const std::string& text, const ParameterSpec& parameters,
                                              std::uint64_t seed, const NamedDesigns& named);

}  // namespace knap
