// picture.svg: the initial and the learned tool, and what they do on some of the test variations.
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

// An SVG file; empty for a scenario that no drawing can show. Throws what RolloutModel throws.
//
// A success test `crosses_opening`, a tool that hangs on the world and does not turn, and neither controls nor a
// policy: two panels, initial and learned. The tool where it first meets the watched body (median over the drawn
// variations), fainter at five equal times on its way, and at the end, the opening as a gap in a line, the start
// rectangle, and the body's path on the first test variations, simulated here.
//
// A success test `holds_rope`: see DrawRopeView.
std::optional<std::string> DrawPicture(RolloutModel& model, const VariationSpec& variations,
                                       const PictureFigures& figures);

// The tool and the rope on the first three test variations, one a column, gravity down: as they start, and at the end
// around the initial and around the learned tool. Empty without a success test `holds_rope` of the only
// designed body, and with controls or a policy.
std::optional<std::string> DrawRopeView(RolloutModel& model, const VariationSpec& variations,
                                        const PictureFigures& figures);

}  // namespace knap
