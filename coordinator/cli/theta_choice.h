// Which designs a command is to look at, as --theta says it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"

namespace knap {

// One design: `learned` is what `read_learned` returns, else see ParseTheta.
std::vector<double> ChooseTheta(const std::string& text, const ParameterSpec& parameters,
                                const std::function<std::vector<double>()>& read_learned);

// One theta a design:
//   random:K            K designs, uniform within the bounds, from the stream kRandomThetas of `seed`
//   else                one design, see ChooseTheta
// Values may lie outside the bounds. Throws UsageError naming what is wrong and what is allowed.
std::vector<std::vector<double>> ChooseThetas(const std::string& text, const ParameterSpec& parameters,
                                              std::uint64_t seed,
                                              const std::function<std::vector<double>()>& read_learned);

}  // namespace knap
