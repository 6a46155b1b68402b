// Writes a scene as a complete scenario file: every field, in canonical order, in SI units.
#pragma once

#include <string>
#include <vector>

#include "sim/scenarios/scene.h"

namespace knap {

// ParseScene of the text gives the same scene, every number to the last bit; equal scenes give equal texts. All numbers
// of the scene are finite.
std::string DumpScene(const Scene& scene);

// The same without `learning` and `evaluation`: what a rollout follows from.
std::string DumpTask(const Scene& scene);

// The key `bodies` of such a file alone.
std::string DumpBodies(const std::vector<Body>& bodies);

}  // namespace knap
