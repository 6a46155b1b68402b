// What the simulator and the designed meshes ask of a scenario beyond what its format says, with the place in the file.
#pragma once

#include "sim/scenarios/scenario_files.h"

namespace knap {

// Adds to scenario.parsed.log:
// - contacts with two shapes that do not touch (pair_rules.h), and contacts that do nothing since forces move neither
//   body;
// - grips between bodies that forces do not move;
// - a designed mesh with a solid inertia;
// - a policy's file of weights that does not fit its network or bounds;
// - files of meshes and cages that hold no mesh or one that bounds no body (triangle_mesh.h), a mesh that cannot be
//   taken apart into convex pieces or reaches out of its cage, and numbers that are no vertex of the cage.
// May follow a LoadScenario that found errors: it tells nothing twice. Reads the meshes; touches no disk.
void CheckModel(LoadedScenario& scenario);

}  // namespace knap
