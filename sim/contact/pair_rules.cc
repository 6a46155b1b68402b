#include "sim/contact/pair_rules.h"

#include <fmt/format.h>

#include <cstddef>
#include <vector>

namespace knap {
namespace {

// What touches has the lower rank, what has the field the higher one.
int GetRank(TouchingKind kind) {
  switch (kind) {
    case TouchingKind::kDesignedMesh:
      return 0;
    case TouchingKind::kBox:
    case TouchingKind::kConvexMesh:
      return 1;
    case TouchingKind::kCylinder:
      return 2;
    case TouchingKind::kSphere:
    case TouchingKind::kCapsule:
      return 3;
    case TouchingKind::kHalfSpace:
      return 4;
  }
  return 4;
}

}  // namespace

PairRule FindPairRule(TouchingKind first, TouchingKind second) {
  const int a = GetRank(first);
  const int b = GetRank(second);
  if (a != b) return a < b ? PairRule::kFirst : PairRule::kSecond;
  // A half-space has no surface that ends.
  return first == TouchingKind::kHalfSpace ? PairRule::kNone : PairRule::kBoth;
}

std::string DescribeNoTouch(TouchingKind first, TouchingKind second) {
  const auto name = [](TouchingKind kind) { return kTouchingKindNames[static_cast<std::size_t>(kind)]; };
  std::vector<std::string_view> others;
  for (std::size_t i = 0; i < kTouchingKindNames.size(); ++i) {
    if (FindPairRule(first, static_cast<TouchingKind>(i)) != PairRule::kNone) others.push_back(kTouchingKindNames[i]);
  }
  return fmt::format("{} and {} do not touch; a {} touches {}", name(first), name(second), name(first),
                     fmt::join(others, ", "));
}

}  // namespace knap
