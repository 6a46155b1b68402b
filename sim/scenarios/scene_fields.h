// The fields of a scenario file, each with its key, unit, allowed range, default and meaning: the one place that knows
// them. Reading, writing, paths of numbers and documentation all derive from it.
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

void VisitBodies(FieldVisitor& v, std::vector<Body>& bodies);

// What signals can name the numbers of, and signals themselves: bodies, contacts and the like.
void VisitWorld(FieldVisitor& v, World& world);

// The world and what is wanted of it: all that a rollout follows from.
void VisitTask(FieldVisitor& v, Scene& scene);

// The task, and how it is learned and evaluated: every field of the scene, in the canonical order of a file.
void VisitFields(FieldVisitor& v, Scene& scene);

}  // namespace knap
