// The numbers of a scene by path: "gravity[2]", "bodies.pea.initial.position[0]", "loss.task[0].at". A path joins keys
// with dots; an element of a list is named by its `name` where it has one, else by its [index].
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct NumericKey {
  std::string path;
  double* value = nullptr;  // into the scene that was asked; valid while none of its lists or variants changes
  Dimension dimension;
  Range range;             // allowed, in SI
  bool read_once = false;  // when the scenario is loaded, not with every draw
};

// Every number (integers are none) of the scene, in the order of its fields.
std::vector<NumericKey> ListNumericKeys(Scene& scene);

// Of the world and of signals alone (VisitWorld): what numbers that signals watch may name.
std::vector<NumericKey> ListWorldKeys(World& world);

// The numbers at `paths`, in their order. Throws std::invalid_argument naming the path that does not exist; a scene
// from ParseScene has all that its variation names. A walk over the scene: some microseconds a body.
std::vector<double*> FindNumericKeys(Scene& scene, std::span<const std::string> paths);

// Whether a variation may change it: the physical scene and its goals, not the design's map, the integrator or the
// learning, nor what is read once.
bool MayVary(const NumericKey& key);

}  // namespace knap
