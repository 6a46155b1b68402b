#include "sim/integrators/step_control.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "sim/contact/contact_mesh.h"
#include "sim/contact/depth_field.h"
#include "sim/integrators/step_formula.h"
#include "sim/math/overloaded.h"

namespace knap {

using Eigen::Ref;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kLeastSpeed = 0.02;   // [m/s]
constexpr double kSpeedMemory = 0.05;  // [s]
constexpr double kSafety = 0.9;
constexpr double kLeastFactor = 0.2;
constexpr double kLargestFactor = 2.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of the solid ball with this mass and moment of inertia about its centre; infinite for a point or no mass.
double CalcBallRadius(const Matrix6d& M) {
  const double mass = M(3, 3);
  if (!(mass > 0.0)) return kInfinity;
  const Vector3d moment(M(2, 4), M(0, 5), M(1, 3));
  const double trace = M.topLeftCorner<3, 3>().trace() - 2.0 * moment.squaredNorm() / mass;
  return trace > 1e-9 * M.topLeftCorner<3, 3>().trace() ? std::sqrt(5.0 / 6.0 * trace / mass) : kInfinity;
}

}  // namespace

StepControl::Ball StepControl::Enclose(const ContactGeometry& shape) {
  return std::visit(
      Overloaded{
          [](const HalfSpaceGeometry& s) {
            return Ball{s.plane, false, Vector3d::Zero(), 0.0, kInfinity};
          },
          [](const SphereGeometry& s) {
            return Ball{{}, s.center.isZero(0.0), s.center, s.radius, s.radius};
          },
          [](const CapsuleGeometry& s) {
            return Ball{{}, false, s.center, s.radius + s.half_length, s.radius};
          },
          [](const CylinderGeometry& s) {
            return Ball{{}, false, s.center, std::hypot(s.half_length, s.radius), std::min(s.half_length, s.radius)};
          },
          [](const BoxGeometry& s) {
            return Ball{{}, false, s.center, s.half.norm(), s.half.minCoeff()};
          },
          [](const MeshGeometry& s) {
            const Eigen::AlignedBox3d& box = s.mesh->bounds();
            const double half_width = s.field ? s.field->deepest : 0.5 * box.sizes().minCoeff();
            return Ball{{}, false, box.center(), 0.5 * box.diagonal().norm(), half_width};
          }},
      shape);
}

StepControl::StepControl(const Tree& tree, const std::vector<ContactPair>& contacts) {
  length_ = kInfinity;
  for (int i = 0; i < tree.size(); ++i) {
    const TreeBody& body = tree.bodies()[i];
    const int n = CountDof(body.joint);
    const bool turns = body.joint == JointType::kRevolute || body.joint == JointType::kBall;
    if (n > 0) joints_.push_back({body.v_start, n, turns});
    if (tree.IsDynamic(i)) length_ = std::min(length_, CalcBallRadius(body.M));
  }
  for (const ContactPair& contact : contacts) {
    Pair pair;
    for (int side = 0; side < 2; ++side) {
      pair.body[side] = contact.bodies[side];
      pair.ball[side] = Enclose(contact.shapes[side]);
      if (tree.IsDynamic(contact.bodies[side])) length_ = std::min(length_, pair.ball[side].half_width);
    }
    // The half-space, if there is one, second.
    if (pair.ball[0].plane) {
      std::swap(pair.body[0], pair.body[1]);
      std::swap(pair.ball[0], pair.ball[1]);
    }
    pairs_.push_back(pair);
  }
  // Point masses that touch nothing have no size: lengths are then seen in metres.
  if (std::isinf(length_)) length_ = 1.0;
}

double StepControl::CalcError(double h, double tolerance, double speed, const Slopes& start, const Slopes& stage,
                              const Slopes& end) const {
  constexpr double w = StepFormula::kWeight;
  constexpr double e0 = w - (1.0 - w) / 3.0;
  constexpr double e1 = w - (1.0 + 3.0 * w) / 3.0;
  constexpr double e2 = 2.0 / 3.0 * StepFormula::kDiagonal;
  double worst = 0.0;
  for (const Joint& joint : joints_) {
    double q2 = 0.0;
    double v2 = 0.0;
    for (int i = joint.start; i < joint.start + joint.size; ++i) {
      const double dq = h * (e0 * start.v(i) + e1 * stage.v(i) + e2 * end.v(i));
      const double dv = h * (e0 * start.vdot(i) + e1 * stage.vdot(i) + e2 * end.vdot(i));
      q2 += dq * dq;
      v2 += dv * dv;
    }
    const double r = joint.turns ? 1.0 : length_;
    const double V = joint.turns ? speed / length_ : speed;
    worst = std::max(worst, q2 / (r * r) + v2 / (V * V));
  }
  return std::sqrt(worst) / tolerance;
}

double StepControl::CalcSpeed(double previous, double h, const Ref<const VectorXd>& v) const {
  double speed = std::max(kLeastSpeed, previous / (1.0 + h / kSpeedMemory));
  for (const Joint& joint : joints_) {
    const double size = v.segment(joint.start, joint.size).norm();
    speed = std::max(speed, joint.turns ? length_ * size : size);
  }
  return speed;
}

double StepControl::CalcFactor(double error) {
  // Also where the error is not a number.
  if (!(error < kInfinity)) return kLeastFactor;
  if (error == 0.0) return kLargestFactor;
  return std::clamp(kSafety / std::cbrt(error), kLeastFactor, kLargestFactor);
}

double StepControl::CalcLongestStep(const std::vector<BodyKinematics>& kinematics) const {
  double longest = kInfinity;
  for (const Pair& pair : pairs_) {
    const BodyKinematics& B = kinematics[pair.body[0]];
    const BodyKinematics& S = kinematics[pair.body[1]];
    const Vector3d c_W = B.X_WB * pair.ball[0].center;
    const auto point_velocity = [&c_W](const BodyKinematics& body) {
      const Vector3d w_W = body.X_WB.R * body.V.head<3>();
      return Vector3d(body.X_WB.R * body.V.tail<3>() + w_W.cross(c_W - body.X_WB.p));
    };
    const Vector3d u = point_velocity(B) - point_velocity(S);
    const Vector3d w = B.X_WB.R * B.V.head<3>() - S.X_WB.R * S.V.head<3>();
    double closing = pair.ball[0].round ? 0.0 : w.norm() * pair.ball[0].radius;
    double gap = 0.0;
    if (pair.ball[1].plane) {
      closing -= (S.X_WB.R * pair.ball[1].plane->n).dot(u);
      gap = pair.ball[1].plane->CalcHeight(S.X_WB.ApplyInverse(c_W)) - pair.ball[0].radius;
    } else {
      closing += u.norm();
      gap = (c_W - S.X_WB * pair.ball[1].center).norm() - pair.ball[0].radius - pair.ball[1].radius;
    }
    if (closing <= 0.0) continue;
    const double half_width = std::min(pair.ball[0].half_width, pair.ball[1].half_width);
    longest = std::min(longest, (std::max(gap, 0.0) + 0.5 * half_width) / closing);
  }
  return longest;
}

}  // namespace knap
