// Whether bodies pass through one another between two states, where forces never saw them touch.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_work.h"

namespace knap {

using Eigen::Vector3d;

namespace {

// Places on the way are this share of the thinner body's half width apart. A step that would ask for more than
// kMostPlaces of them is one over which nobody can vouch for anything.
constexpr double kApart = 0.25;
constexpr double kMostPlaces = 4096.0;

// The shares s of [0, 1] at which |x + s d| < r; begin = end where there are none.
struct Part {
  double begin = 0.0, end = 0.0;
};
Part FindWithin(const Vector3d& x, const Vector3d& d, double r) {
  const double a = d.squaredNorm();
  const double b = x.dot(d);
  const double c = x.squaredNorm() - r * r;
  if (a == 0.0) return c < 0.0 ? Part{0.0, 1.0} : Part{};
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0.0)) return {};
  const double root = std::sqrt(discriminant);
  const double begin = std::clamp((-b - root) / a, 0.0, 1.0);
  return {begin, std::clamp((-b + root) / a, begin, 1.0)};
}

}  // namespace

void ContactModel::NotePoses() {
  work_->noted.resize(work_->sides.size());
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    work_->noted[s] = {work_->states[s].X_SB, work_->states[s].depth_share};
  }
}

int ContactModel::FindPassage() {
  if (work_->noted.empty()) return -1;
  for (std::size_t s = 0; s < work_->sides.size(); ++s) {
    if (LeadsThrough(s)) return work_->sides[s].pair;
  }
  return -1;
}

bool ContactModel::LeadsThrough(std::size_t s) {
  const NotedSide& from = work_->noted[s];
  const Pose& to = work_->states[s].X_SB;
  if (from.depth_share > kPassage || work_->states[s].depth_share > kPassage) return false;
  const NearFacets& near = work_->near[s];
  if (std::isinf(near.radius_S())) return false;  // there is no other side to come out at
  const Vector3d center = near.center_B();
  const Vector3d begin = from.X_SB * center;
  const Vector3d shift = to * center - begin;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.R * from.X_SB.R.transpose()));
  if (shift.norm() + turn.angle() * near.radius_B() <= kApart * work_->sides[s].size) return false;
  const Part part = FindWithin(begin - near.center_S(), shift, near.radius_B() + near.radius_S());
  const double way = (part.end - part.begin) * (shift.norm() + turn.angle() * near.radius_B());
  const double places = std::ceil(way / (kApart * work_->sides[s].size));
  if (!(places <= kMostPlaces)) return true;
  const int count = static_cast<int>(places);
  for (int i = 0; i <= count && part.end > part.begin; ++i) {
    const double share = part.begin + (part.end - part.begin) * i / std::max(count, 1);
    Pose X_SB;
    X_SB.R = Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix() * from.X_SB.R;
    X_SB.p = begin + share * shift - X_SB.R * center;
    CalcPatches(work_->sides[s], &work_->near[s], X_SB, &work_->on_the_way);
    for (const PatchIntegrals& patch : work_->on_the_way.patches) {
      if (patch.active() && patch.depth > kPassage * work_->sides[s].deepest) return true;
    }
  }
  return false;
}

}  // namespace knap
