// What a contact model keeps of its sides from one evaluation to what follows it, and its scratch; for its own sources.
#pragma once

#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/contact/patch_law.h"

namespace knap {

// One patch in contact.
struct Touch {
  int cell = 0;
  int previous = -1;  // its bristle among those at the step's start
  PatchLaw law;
  PatchCotangent bar;
};

// One side at the last evaluation.
struct SideState {
  Pose X_SB;
  double depth_share = 0.0;
  SidePatches at;
  std::vector<Touch> touches;  // the first num_touches of them, in the order of their cells
  int num_touches = 0;
  PairWrench wrench;
};

// One side where NotePoses saw it.
struct NotedSide {
  Pose X_SB;
  double depth_share = 0.0;
};

struct ContactModel::Work {
  std::vector<ContactSide> sides;
  std::vector<NearFacets> near;  // one a side, as all that follow
  std::vector<SideState> states;
  std::vector<NotedSide> noted;  // none before NotePoses
  std::vector<double> bearing;   // scratch of AddWrenches, one a contact: the weights of the reports' p_W [N]
  SidePatches on_the_way;        // scratch of FindPassage
  double h = 0.0;                // of the step [s]
  Bristles previous;             // at its start
};

}  // namespace knap
