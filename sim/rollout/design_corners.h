// Designs at the ends of their bounds that fold a mesh or turn it inside out: an evaluation there is rejected, and a
// learner that may go there learns less than it could.
#pragma once

#include <Eigen/Core>
#include <string>

#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct FoldedCorners {
  int tried = 0;
  int folded = 0;
  Eigen::VectorXd example{};  // the first of them, and what it does
  std::string fault{};
  // Of the way from the initial design to each of the folded ones, that at which none of them is [%].
  int safe_percent = 100;
};

// The largest whole percentage, up to `most`, of the way from the initial design to `theta` at which a design has no
// fault, by bisection: between it and a larger one there is a design that has. 0 where there is none.
int FindSafePercent(const SceneDesign& design, const Eigen::VectorXd& theta, int most = 100);

// Tries each parameter at either bound with the others at their initial values, and then the corners of the box of all
// bounds: all of them up to ten parameters, else a thousand, the same in every call, and fewer of a mesh of more than
// 2,000 triangles. Of the cost of some 3,000 meshes at most.
FoldedCorners FindFoldedCorners(const SceneDesign& design, const Design& bounds);

}  // namespace knap
