// The fields of joints and of their initial states (scene_fields.h).
#pragma once

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Every number of a default-initialised vector may be left out.
template <class Vector>
void VisitVector(FieldVisitor& v, std::string_view key, std::string_view doc, const Dimension& dimension,
                 Vector& vector) {
  v.Numbers({.key = key, .doc = doc, .required = false, .dimension = dimension}, vector);
}

void VisitFields(FieldVisitor& v, Joint& joint);

// `initial`, which the body has beside its joint; nothing for joints without a state.
void VisitInitialState(FieldVisitor& v, JointKind& kind);

}  // namespace knap
