// Which shapes touch one another, and how: the one table that contacts, checks of scenarios and their documentation
// read.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace knap {

enum class TouchingKind { kHalfSpace, kSphere, kCapsule, kCylinder, kBox, kConvexMesh, kDesignedMesh };

inline constexpr std::array<std::string_view, 7> kTouchingKindNames = {
    "half_space", "sphere", "capsule", "cylinder", "box", "mesh", "designed_mesh"};

// Which of two shapes is cut up in the depth field of the other; both: each in the other's, with half of the modulus.
enum class PairRule { kNone, kFirst, kSecond, kBoth };

PairRule FindPairRule(TouchingKind first, TouchingKind second);

// "half_space and half_space do not touch; a half_space touches sphere, …", where the rule is kNone.
std::string DescribeNoTouch(TouchingKind first, TouchingKind second);

}  // namespace knap
