#include "sim/geometry/polygon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

namespace knap {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Of the polygon's size: what is nearer to a line than this counts as lying on it. Coordinates of nine digits, which is
// what most files have, are rounded more coarsely, those of double precision far less.
constexpr double kOnLine = 1e-10;

double CalcCross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// How far p lies to the left of the line from a to b.
double CalcLeft(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d ab = b - a;
  return CalcCross(ab, p - a) / ab.norm();
}

// The corners along the coordinate axis that is nearest to the normal, counter-clockwise.
std::vector<Vector2d> Flatten(const std::vector<Vector3d>& corners) {
  const Vector3d& o = corners.front();
  Vector3d twice_area = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) twice_area += (corners[i] - o).cross(corners[i + 1] - o);
  int axis = 0;
  twice_area.cwiseAbs().maxCoeff(&axis);
  int x = (axis + 1) % 3;
  int y = (axis + 2) % 3;
  if (twice_area[axis] < 0.0) std::swap(x, y);
  std::vector<Vector2d> flat;
  flat.reserve(corners.size());
  for (const Vector3d& corner : corners) flat.emplace_back(corner[x] - o[x], corner[y] - o[y]);
  return flat;
}

// Whether the inner parts of two edges cross at a point.
bool Cross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d, double tolerance) {
  const double ends[] = {CalcLeft(a, b, c), CalcLeft(a, b, d), CalcLeft(c, d, a), CalcLeft(c, d, b)};
  if (!std::all_of(std::begin(ends), std::end(ends), [&](double x) { return std::abs(x) > tolerance; })) return false;
  return (ends[0] > 0.0) != (ends[1] > 0.0) && (ends[2] > 0.0) != (ends[3] > 0.0);
}

class EarCutter {
 public:
  explicit EarCutter(const std::vector<Vector3d>& corners) : at_(Flatten(corners)) {
    double size = 0.0;
    for (const Vector2d& corner : at_) size = std::max(size, corner.cwiseAbs().maxCoeff());
    tolerance_ = kOnLine * size;
    for (std::size_t i = 0; i < at_.size(); ++i) left_.push_back(static_cast<int>(i));
  }

  double tolerance() const { return tolerance_; }
  const std::vector<Vector2d>& at() const { return at_; }

  // Cuts ears until a triangle is left. False when there is none to cut.
  bool CutAll(std::vector<Vector3i>* triangles) {
    std::size_t look = 1;
    while (left_.size() > 3) {
      std::size_t ear = FindEar(look, tolerance_);
      if (ear == left_.size()) ear = FindEar(look, 0.0);
      if (ear == left_.size()) return false;
      triangles->push_back(GetTriangle(ear));
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
      look = ear % left_.size();  // the corner behind the ear: looking on from there spares most corners a second look
    }
    triangles->push_back(GetTriangle(1));
    return IsConvex(triangles->back(), 0.0);
  }

 private:
  // The corner at `i` between its neighbours; the triangle begins with the one before.
  Vector3i GetTriangle(std::size_t i) const {
    const std::size_t n = left_.size();
    return {left_[(i + n - 1) % n], left_[i], left_[(i + 1) % n]};
  }

  bool IsConvex(const Vector3i& t, double tolerance) const {
    const Vector2d &a = at_[t[0]], &b = at_[t[1]], &c = at_[t[2]];
    return a != b && b != c && c != a && CalcLeft(a, b, c) > tolerance && CalcLeft(b, c, a) > tolerance &&
           CalcLeft(c, a, b) > tolerance;
  }

  // Whether one of the remaining corners lies in the triangle or on it. Corners at the place of one of the triangle's
  // own, the other end of a bridge, do not count.
  bool HoldsCorner(const Vector3i& t, double tolerance) const {
    const Vector2d &a = at_[t[0]], &b = at_[t[1]], &c = at_[t[2]];
    const Vector2d low = a.cwiseMin(b).cwiseMin(c).array() - tolerance;
    const Vector2d high = a.cwiseMax(b).cwiseMax(c).array() + tolerance;
    return std::any_of(left_.begin(), left_.end(), [&](int i) {
      const Vector2d& p = at_[i];
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any() || p == a || p == b || p == c) {
        return false;
      }
      return CalcLeft(a, b, p) >= -tolerance && CalcLeft(b, c, p) >= -tolerance && CalcLeft(c, a, p) >= -tolerance;
    });
  }

  // The first ear from `begin` on, round about; left_.size() when there is none.
  std::size_t FindEar(std::size_t begin, double tolerance) const {
    const std::size_t n = left_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = (begin + k) % n;
      const Vector3i t = GetTriangle(i);
      if (IsConvex(t, tolerance) && !HoldsCorner(t, tolerance)) return i;
    }
    return n;
  }

  std::vector<Vector2d> at_;
  std::vector<int> left_;  // corners not yet cut off
  double tolerance_ = 0.0;
};

std::string FindCrossedEdges(const std::vector<Vector2d>& at, double tolerance) {
  const std::size_t n = at.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (Cross(at[i], at[i + 1], at[j], at[(j + 1) % n], tolerance)) {
        return fmt::format("the outline crosses itself: the edge behind corner {} and the one behind corner {}", i + 1,
                           j + 1);
      }
    }
  }
  return {};
}

}  // namespace

PolygonSplit SplitPolygon(const std::vector<Vector3d>& corners) {
  PolygonSplit split;
  if (corners.size() == 3) {
    split.triangles.emplace_back(0, 1, 2);
    return split;
  }
  EarCutter cutter(corners);
  if (!cutter.CutAll(&split.triangles)) split.fault = "the outline encloses no area, or touches itself";
  // Ears can be cut off some outlines that cross themselves, too.
  const std::string crossed = FindCrossedEdges(cutter.at(), cutter.tolerance());
  if (!crossed.empty()) split.fault = crossed;
  if (!split.fault.empty()) split.triangles.clear();
  return split;
}

}  // namespace knap
