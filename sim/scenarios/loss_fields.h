// The fields of a scene's loss and success test.
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

void VisitFields(FieldVisitor& v, Loss& loss);
void VisitFields(FieldVisitor& v, SuccessTest& test);

}  // namespace knap
