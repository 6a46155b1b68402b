// Prescribed motions: V and A against differences of the pose and of V, and what their parameters mean.
#include "sim/multibody/motions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "sim/math/so3.h"

namespace knap {
namespace motions_test {

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

// Through its points, level at its ends, without jumps of the acceleration, and the least bent of all such curves: a
// bump of any height that is level at the ends and leaves the points alone bends it more.
TEST(CubicSpline, PassesThroughItsPointsSmoothly) {
  const std::vector<double> times{0.1, 0.3, 0.45, 1.0, 1.2};
  const std::vector<double> values{1.0, -0.5, 0.7, 0.7, 2.0};
  const CubicSpline spline(times, values);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(spline.Calc(times[i]).x, values[i], 1e-15);
    if (i == 0 || i + 1 == times.size()) continue;
    const CubicSpline::Value before = spline.Calc(times[i] - 1e-9), after = spline.Calc(times[i] + 1e-9);
    EXPECT_NEAR(before.rate, after.rate, 1e-6);
    EXPECT_NEAR(before.acceleration, after.acceleration, 1e-4);
  }
  EXPECT_NEAR(spline.Calc(0.1 + 1e-9).rate, 0.0, 1e-6);
  EXPECT_NEAR(spline.Calc(1.2 - 1e-9).rate, 0.0, 1e-6);
  EXPECT_EQ(spline.Calc(-3.0).x, 1.0);
  EXPECT_EQ(spline.Calc(9.0).x, 2.0);
  EXPECT_EQ(spline.Calc(9.0).rate, 0.0);
  const double h = 1e-6;
  for (int i = 1; i < 100; ++i) {
    const double t = 0.1 + 0.011 * i + 1e-4;
    const CubicSpline::Value at = spline.Calc(t), low = spline.Calc(t - h), high = spline.Calc(t + h);
    EXPECT_NEAR(at.rate, (high.x - low.x) / (2.0 * h), 1e-6);
    EXPECT_NEAR(at.acceleration, (high.rate - low.rate) / (2.0 * h), 1e-4);
    EXPECT_NEAR(at.jerk, (high.acceleration - low.acceleration) / (2.0 * h), 1e-1);
  }
  double bending = 0.0, bumped = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double t = 0.1 + 1.1 * (i + 0.5) / 20000;
    // x = sin²(pi s) with s whole at the points 0.45 and 1.0, level there; elsewhere nothing.
    const double s = (t - 0.45) / 0.55;
    constexpr double kPi = 3.141592653589793;
    const double bump = s > 0.0 && s < 1.0 ? 2.0 * (kPi / 0.55) * (kPi / 0.55) * std::cos(2.0 * kPi * s) : 0.0;
    const double a = spline.Calc(t).acceleration;
    bending += a * a;
    for (const double height : {0.1, -0.1}) bumped += 0.5 * (a + height * bump) * (a + height * bump);
  }
  EXPECT_LT(bending, bumped);
  EXPECT_THROW(CubicSpline({0.0}, {1.0}), std::invalid_argument);
  EXPECT_THROW(CubicSpline({0.0, 0.0}, {1.0, 2.0}), std::invalid_argument);
}

TEST(Compose, RatesEqualDifferences) {
  const CubicSpline a({0.0, 0.4, 1.0}, {0.0, 0.9, -0.4});
  const CubicSpline b({0.0, 0.5, 1.0}, {0.3, -0.7, 1.1});
  const CubicSpline c({0.0, 0.6, 1.0}, {-0.2, 0.1, 0.5});
  const auto motion = [&](double t) {
    PrescribedState state = CalcTurn(Vector3d(1.0, 2.0, 2.0) / 3.0, a.Calc(t));
    state = Compose(state, CalcShift(Vector3d(0.6, 0.0, 0.8), b.Calc(t)));
    state = Compose(state, CalcTurn(Vector3d::UnitY(), c.Calc(t)));
    return Compose(state, CalcTurn(Vector3d::UnitZ(), b.Calc(t)));
  };
  for (int i = 1; i < 20; ++i) CheckRates(motion, 0.05 * i + 0.013, 2e-7);
}

}  // namespace motions_test
}  // namespace knap
