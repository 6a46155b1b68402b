// The fields of what drives actuators (scene_fields.h).
#pragma once

#include "sim/scenarios/controls.h"
#include "sim/scenarios/field_visitor.h"

namespace knap {

void VisitFields(FieldVisitor& v, Controls& controls);

// After everything whose numbers the policy may observe.
void VisitFields(FieldVisitor& v, Policy& policy);

}  // namespace knap
