// landscape.svg: a slice of the loss as a picture.
#pragma once

#include <string>

#include "coordinator/landscape/landscape.h"
#include "coordinator/learning/problem.h"

namespace knap {

struct LandscapeCaption {
  std::string title;         // "pushing"
  std::string subtitle;      // what was averaged, and what all other parameters are
  std::string theta_name;    // of the design that the slice goes through, "initial"
  bool has_success = false;  // the scenario has a success test: a second panel shows its rate
};

// Filled cells with contour lines, a panel for the mean loss and one for the success rate: axes in the parameters'
// units (lengths in mm), a colour bar each, a ring at the least loss and a cross where the slice's own design lies, if
// within. Cells with rollouts that are not finite or not converged are hatched; a cell without any finite loss is grey.
// Throws std::runtime_error when no cell has a loss.
std::string DrawLandscape(const Landscape& landscape, const ParameterSpec& parameters, const LandscapeCaption& caption);

}  // namespace knap
