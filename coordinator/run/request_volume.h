// How much may be asked in one call: its rollouts are held in memory, each with all parameters.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>

namespace knap {

// Throws UsageError when the product of `counts`, which is the number of rollouts, exceeds 10 million, or these with
// `values_each` numbers each exceed 250 million (2 GB). `what` says where the counts come from. Nothing overflows: the
// product is a real number.
void CheckRequestVolume(const std::string& what, std::initializer_list<double> counts, std::size_t values_each);

}  // namespace knap
