// What `knap evaluate --perturb` asks: a scenario whose physics is not quite what the tool was learned for.
#pragma once

#include "sim/scenarios/scenario_files.h"

namespace knap {

// Adds the section `perturbation` to the scene, and to what varies its numbers, each uniform and independent:
//
//   friction, where there are contacts; mass, where forces move anything; speed, where motions are prescribed   0.75
//   … 1.25 of the start of each free body that the world carries, and of each rope: along, across ±2 mm (a helix has no
//   across), turn                                                                                ±2°
//
// They stand behind what the scenario itself varies, so that of a variation of the same number the rest is as ever.
// Throws UsageError where the scene has such a section of its own.
void AddPerturbation(LoadedScenario* scenario);

}  // namespace knap
