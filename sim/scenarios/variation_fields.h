// The fields of what differs between rollouts (scene_fields.h).
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

// After everything whose numbers may vary.
void VisitFields(FieldVisitor& v, Variation& variation);

}  // namespace knap
