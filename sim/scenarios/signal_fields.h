// The fields of signals (scene_fields.h), and what unit a signal has.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/scene.h"

namespace knap {

void VisitFields(FieldVisitor& v, Signal& signal);

// By name; a signal of signals has that of the first of them. None of an unknown or misspelt one.
class SignalDimensions {
 public:
  // `world` stays as it is: visitors take no const one.
  explicit SignalDimensions(World& world);

  std::optional<Dimension> Find(const std::string& signal) const;

  // A field of the dimension of a signal; of any where that is unknown, which has been reported.
  FieldInfo With(FieldInfo info, const std::string& signal) const;

 private:
  std::map<std::string, Dimension> dimensions_;
};

}  // namespace knap
