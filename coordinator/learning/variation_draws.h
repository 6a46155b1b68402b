// Drawing the numbers of one entry of a VariationSpec, and what they can be (problem.h).
#pragma once

#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/random/counter_random.h"

namespace knap {

// What is wrong with the entry, or empty.
std::string FindDrawFault(const VariationKeys& keys);

// One number for each name, added to *values.
void DrawVariation(const VariationKeys& keys, CounterRandom& random, std::vector<double>* values);

// Likewise.
void AddDrawRanges(const VariationKeys& keys, std::vector<DrawRange>* ranges);

}  // namespace knap
