// The fields of what drives actuators (scene_fields.h).
#pragma once

#include "sim/scenarios/controls.h"
#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/signal_fields.h"

namespace knap {

void VisitFields(FieldVisitor& v, Controls& controls);

void VisitPolicy(FieldVisitor& v, const SignalDimensions& signals, Policy& policy);

}  // namespace knap
