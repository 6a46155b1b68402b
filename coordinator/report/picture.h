// picture.svg: the initial and the learned tool from above, and what they do on some of the test variations.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/learning/evaluation.h"
#include "coordinator/learning/problem.h"
#include "sim/rollout/rollout.h"

namespace knap {

struct PictureFigures {
  TestSummary test_initial;
  std::vector<double> learned;  // theta, d values
  TestSummary test_learned;     // same seed as test_initial
};

// An SVG file of two panels, initial and learned: the tool where it first meets the watched body (median over the drawn
// variations), fainter at five equal times on its way, and at the end, the opening as a gap in a line, the start
// rectangle, and the body's path on the first test variations, simulated here.
//
// Empty for a scenario this drawing cannot show: it needs a success test `crosses_opening` a tool that hangs on the
// world and does not turn, and no controls. Throws what RolloutModel throws.
std::optional<std::string> DrawTopView(RolloutModel& model, const VariationSpec& variations,
                                       const PictureFigures& figures);

}  // namespace knap
