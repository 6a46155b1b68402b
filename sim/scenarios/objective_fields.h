// The fields of a scene's loss and success (scene_fields.h).
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"
#include "sim/scenarios/signal_fields.h"

namespace knap {

void VisitObjective(FieldVisitor& v, const SignalDimensions& signals, Loss& loss);
void VisitObjective(FieldVisitor& v, const SignalDimensions& signals, Condition& condition);

}  // namespace knap
