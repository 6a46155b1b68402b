// The name a reader probably meant.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace knap {

// Number of insertions, deletions, replacements and swaps of neighbours that turn a into b (optimal string alignment).
// Cost a.size()·b.size().
std::size_t CalcEditDistance(std::string_view a, std::string_view b);

// The first of `names` with the smallest edit distance to `name`; empty when none is within a third of the longer one's
// length, so that the suggestion is worth reading.
std::string FindNearestName(std::string_view name, std::span<const std::string> names);

}  // namespace knap
