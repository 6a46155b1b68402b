// Fields that several parts of a scene have.
#pragma once

#include <string_view>

#include "sim/scenarios/axis.h"
#include "sim/scenarios/field_visitor.h"

namespace knap {

inline constexpr std::string_view kAxisNames[] = {"x", "y", "z"};
inline constexpr Range kCount{1.0, 1e9};
inline constexpr Range kFraction{0.0, 1.0, true};
inline constexpr Range kSeed{0.0, 9007199254740991.0};  // exact in every language that keeps numbers as doubles

// Every number of a default-initialised vector may be left out.
template <class Vector>
void VisitVector(FieldVisitor& v, std::string_view key, std::string_view doc, const Dimension& dimension,
                 Vector& vector) {
  v.Numbers({.key = key, .doc = doc, .required = false, .dimension = dimension}, vector);
}

inline void VisitAxis(FieldVisitor& v, std::string_view key, std::string_view doc, Axis& axis) {
  v.EnumField({.key = key, .doc = doc}, axis, kAxisNames);
}

}  // namespace knap
