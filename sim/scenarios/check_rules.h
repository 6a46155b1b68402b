// Rules that several checks of a scene use.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "sim/scenarios/scene.h"

namespace knap {

// Rounding in numbers that a person wrote in decimal.
inline constexpr double kDecimalRoundOff = 1e-9;

// Of a rollout: states are kept, and counts of steps must fit an int with room to spare.
inline constexpr double kMostSteps = 1e6;

inline bool IsWholeMultiple(double x, double unit) {
  const double ratio = x / unit;
  return std::abs(ratio - std::round(ratio)) <= kDecimalRoundOff * std::max(1.0, std::abs(ratio)) &&
         std::round(ratio) >= 1.0;
}

template <class T>
bool HasRepeats(const std::vector<T>& items) {
  return std::set<T>(items.begin(), items.end()).size() != items.size();
}

// Of a body's shapes the first of this kind; null without one.
template <class Kind>
const Shape* FindShape(const Body& body) {
  const auto found = std::find_if(body.shapes.begin(), body.shapes.end(),
                                  [](const Shape& s) { return std::holds_alternative<Kind>(s.kind); });
  return found == body.shapes.end() ? nullptr : &*found;
}

inline std::string GetShapePath(const Body& body, std::size_t index) {
  return "bodies." + body.name + ".shapes[" + std::to_string(index) + "]";
}

// Null without such a body or rope.
inline const Body* FindBody(const World& world, const std::string& name) {
  const auto found =
      std::find_if(world.bodies.begin(), world.bodies.end(), [&](const Body& b) { return b.name == name; });
  return found == world.bodies.end() ? nullptr : &*found;
}

inline const Rope* FindRope(const World& world, const std::string& name) {
  const auto found =
      std::find_if(world.ropes.begin(), world.ropes.end(), [&](const Rope& r) { return r.name == name; });
  return found == world.ropes.end() ? nullptr : &*found;
}

}  // namespace knap
