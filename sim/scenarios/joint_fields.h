// The fields of joints and of their initial states (scene_fields.h).
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

void VisitFields(FieldVisitor& v, Joint& joint);

// `initial`, which the body has beside its joint; nothing for joints without a state.
void VisitInitialState(FieldVisitor& v, JointKind& kind);

}  // namespace knap
