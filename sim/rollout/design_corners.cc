#include "sim/rollout/design_corners.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace knap {
namespace {

constexpr int kAllCornersUpTo = 10;    // parameters
constexpr int kSampledCorners = 1000;  // at most, and at least …
constexpr int kFewestCorners = 20;
constexpr std::size_t kSampledTriangles = 2'000'000;  // … as long as all their meshes have no more

}  // namespace

int FindSafePercent(const SceneDesign& design, const Eigen::VectorXd& theta, int most) {
  const Eigen::VectorXd way = theta - design.initial_theta();
  const auto is_safe = [&](int percent) {
    return design.FindFault(design.initial_theta() + percent / 100.0 * way).empty();
  };
  if (is_safe(most)) return most;
  int safe = 0;
  for (int folded = most; folded - safe > 1;) {
    const int middle = (safe + folded) / 2;
    (is_safe(middle) ? safe : folded) = middle;
  }
  return safe;
}

FoldedCorners FindFoldedCorners(const SceneDesign& design, const Design& bounds) {
  FoldedCorners found;
  std::vector<Eigen::VectorXd> folded;
  const auto try_theta = [&](const Eigen::VectorXd& theta) {
    ++found.tried;
    std::string fault = design.FindFault(theta);
    if (fault.empty()) return;
    if (folded.empty()) found.fault = std::move(fault);
    folded.push_back(theta);
  };
  const int d = design.num_parameters();
  const auto bound = [&](int i, bool upper) {
    const DesignParameter& parameter = bounds.parameters[static_cast<std::size_t>(i)];
    return double{upper ? parameter.upper : parameter.lower};
  };
  for (int i = 0; i < d; ++i) {
    for (const bool upper : {false, true}) {
      Eigen::VectorXd theta = design.initial_theta();
      theta(i) = bound(i, upper);
      try_theta(theta);
    }
  }
  std::mt19937_64 random(1);
  const bool all = d <= kAllCornersUpTo;
  std::size_t triangles = 1;
  for (const std::string& body : design.bodies()) triangles += design.Find(body)->initial_mesh().triangles.size();
  const int affordable = std::clamp(static_cast<int>(kSampledTriangles / triangles), kFewestCorners, kSampledCorners);
  const int corners = all ? 1 << d : affordable;
  for (int corner = 0; corner < corners; ++corner) {
    Eigen::VectorXd theta(d);
    std::uint64_t bits = static_cast<std::uint64_t>(corner);
    for (int i = 0; i < d; ++i) {
      if (!all && i % 64 == 0) bits = random();
      theta(i) = bound(i, (bits >> (i % 64) & 1) != 0);
    }
    try_theta(theta);
  }
  found.folded = static_cast<int>(folded.size());
  if (folded.empty()) return found;
  found.example = folded.front();
  // Again for all where one lowers it: a fold may come, go and come again on the way.
  int before = 0;
  do {
    before = found.safe_percent;
    for (const Eigen::VectorXd& theta : folded) {
      found.safe_percent = FindSafePercent(design, theta, found.safe_percent);
    }
  } while (found.safe_percent < before);
  return found;
}

}  // namespace knap
