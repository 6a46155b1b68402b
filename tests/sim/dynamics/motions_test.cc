// Prescribed motions: V and A against differences of the pose and of V, and what their parameters mean.
#include "sim/multibody/motions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The twist in B from central differences of the pose: [w]× = Rᵀ dR/dt, v = Rᵀ dp/dt.
Vector6d DifferenceTwist(const PrescribedMotion& motion, double time, double h) {
  const Pose before = motion(time - h).X_FB;
  const Pose after = motion(time + h).X_FB;
  const Matrix3d R = motion(time).X_FB.R;
  const Matrix3d spin = R.transpose() * (after.R - before.R) / (2.0 * h);
  Vector6d V;
  V << 0.5 * (spin(2, 1) - spin(1, 2)), 0.5 * (spin(0, 2) - spin(2, 0)), 0.5 * (spin(1, 0) - spin(0, 1)),
      R.transpose() * (after.p - before.p) / (2.0 * h);
  return V;
}

void CheckRates(const PrescribedMotion& motion, double time, double tolerance) {
  const double h = 1e-5;  // truncation 1e-10 × third derivatives, rounding 1e-11
  const PrescribedState state = motion(time);
  EXPECT_LT((state.V - DifferenceTwist(motion, time, h)).norm(), tolerance) << "V at " << time;
  const Vector6d A = (motion(time + h).V - motion(time - h).V) / (2.0 * h);
  EXPECT_LT((state.A - A).norm(), tolerance) << "A at " << time;
  const Vector6d jerk = (motion(time + h).A - motion(time - h).A) / (2.0 * h);
  EXPECT_LT((state.jerk - jerk).norm(), 100.0 * tolerance) << "jerk at " << time;
}

TEST(Zigzag, RatesEqualDifferences) {
  for (const double sharpness : {0.1, 0.6, 0.95}) {
    const Zigzag zigzag{0.06, 3.0, sharpness, 0.06, 0.37};
    const auto motion = [&](double t) { return CalcZigzag(zigzag, t); };
    for (int i = 0; i < 61; ++i) CheckRates(motion, 0.013 + 0.1 * i, 2e-8);  // none at the stop, 6.1667 s
    CheckRates(motion, 6.5, 2e-8);
  }
}

TEST(Zigzag, TurnsAtItsAmplitudeAndStops) {
  const Zigzag zigzag{0.06, 3.0, 0.95, 0.06, 0.37};
  EXPECT_NEAR(CalcZigzag(zigzag, 0.75).X_FB.p.x(), 0.06, 1e-15);
  EXPECT_NEAR(CalcZigzag(zigzag, 0.75).V(3), 0.0, 1e-14);
  EXPECT_NEAR(CalcZigzag(zigzag, 2.25).X_FB.p.x(), -0.06, 1e-15);
  EXPECT_NEAR(CalcZigzag(zigzag, 3.0).X_FB.p.x(), 0.0, 1e-15);
  EXPECT_NEAR(CalcZigzag(zigzag, 1.0).X_FB.p.y(), 0.06, 1e-15);
  EXPECT_EQ(CalcZigzag(zigzag, 7.0).X_FB.p.y(), 0.37);
  EXPECT_EQ(CalcZigzag(zigzag, 7.0).V(4), 0.0);
}

TEST(Zigzag, ApproachesASineAndATriangleWave) {
  constexpr double kTwoPi = 6.283185307179586;
  double previous = 1.0;
  for (const double k : {0.2, 0.1, 0.05}) {
    double worst = 0.0;
    for (int i = 0; i < 100; ++i) {
      const double t = 0.01 * i;
      worst = std::max(worst, std::abs(CalcZigzag({1.0, 1.0, k, 0, 0}, t).X_FB.p.x() - std::sin(kTwoPi * t)));
    }
    EXPECT_LT(worst, 0.3 * previous);  // the difference is of order k²
    previous = worst;
  }
  previous = 1.0;
  for (const double k : {0.9, 0.99, 0.9999}) {
    double worst = 0.0;
    for (int i = 0; i <= 100; ++i) {
      const double t = 0.0025 * i;  // the rising quarter: a triangle wave climbs 4 t
      worst = std::max(worst, std::abs(CalcZigzag({1.0, 1.0, k, 0, 0}, t).X_FB.p.x() - 4.0 * t));
    }
    EXPECT_LT(worst, 0.5 * previous);
    previous = worst;
  }
}

TEST(ConstantVelocity, RatesEqualDifferencesAndStayConstantInF) {
  const Vector3d v(0.3, -0.2, 0.5);
  for (const Vector3d& w : {Vector3d(0, 0, 0), Vector3d(0.5, 1.0, -2.0)}) {
    const auto motion = [&](double t) { return CalcConstantVelocity(v, w, t); };
    for (const double time : {0.0, 0.4, 1.7, 5.0}) {
      CheckRates(motion, time, 1e-8);
      const PrescribedState s = motion(time);
      EXPECT_LT((s.X_FB.R * s.V.head<3>() - w).norm(), 1e-14);
      EXPECT_LT((s.X_FB.R * s.V.tail<3>() - v).norm(), 1e-14);
      EXPECT_LT((s.X_FB.p - time * v).norm(), 1e-15 * (1.0 + time));
    }
  }
}

std::vector<MotionPiece> MakePieces() {
  return {{1.0, 0.3, Vector3d(0.1, 0.0, -0.2), Vector3d::Zero()},
          {2.0, 0.5, Vector3d(0.0, 0.3, 0.1), Vector3d(-7.0, 2.0, 1.0)},
          {0.5, 0.25, Vector3d::Zero(), Vector3d(0.0, 0.4, 3.0)}};
}

TEST(Pieces, RatesEqualDifferences) {
  const auto motion = [](double t) { return CalcPieces(MakePieces(), t); };
  // Jerk jumps at the ends of ramps, which differences smear over their step.
  for (int i = 0; i < 40; ++i) CheckRates(motion, 0.013 + 0.1 * i, 2e-7);
}

TEST(Pieces, GoWhereTheySayAndRestThere) {
  const std::vector<MotionPiece> pieces = MakePieces();
  for (const double time : {0.0, 1.0, 3.0, 3.5, 9.0}) {
    const PrescribedState state = CalcPieces(pieces, time);
    EXPECT_LT(state.V.norm(), 1e-12) << time;
    EXPECT_LT(state.A.norm(), 1e-12) << time;
  }
  // Turns about axes of F, the later on the outside.
  const Matrix3d R = (ExpSo3(pieces[2].turn) * ExpSo3(pieces[1].turn)).toRotationMatrix();
  EXPECT_LT((CalcPieces(pieces, 9.0).X_FB.R - R).norm(), 1e-14);
  EXPECT_LT((CalcPieces(pieces, 9.0).X_FB.p - Vector3d(0.1, 0.3, -0.1)).norm(), 1e-15);
  // Between the ramps the speed is constant: of 2 s, 0.5 s at either end count half.
  EXPECT_LT((CalcPieces(pieces, 2.0).X_FB.R * CalcPieces(pieces, 2.0).V.head<3>() - pieces[1].turn / 1.5).norm(),
            1e-13);
}

}  // namespace
}  // namespace knap
