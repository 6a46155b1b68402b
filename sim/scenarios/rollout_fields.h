// The fields of how a scene is simulated and what its gradients are held to.
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

void VisitFields(FieldVisitor& v, Rollout& rollout);
void VisitFields(FieldVisitor& v, GradientDemand& demand);
void VisitFields(FieldVisitor& v, TrustDemand& demand);

}  // namespace knap
