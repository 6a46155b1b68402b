// Forces within a joint: what each law promises (sign, smoothness, saturation), and derivatives against differences.
#include "sim/multibody/joint_forces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/math/so3.h"

namespace knap {
namespace joint_forces_test {

using Eigen::Vector3d;

const JointLimit kLimit{-0.4, 0.7, 50.0, 0.8, 0.02};

double Limit(double x, double v) {
  JointForce force;
  AddLimit(kLimit, x, v, &force);
  return force.tau(0);
}

TEST(JointLimit, PushesBackOnlyAndOnlyBeyondTheEnds) {
  for (double v = -20.0; v <= 20.0; v += 0.5) {
    EXPECT_EQ(Limit(0.7, v), 0.0);
    EXPECT_EQ(Limit(-0.4, v), 0.0);
    EXPECT_EQ(Limit(0.1, v), 0.0);
    for (double depth = 0.001; depth < 0.3; depth += 0.01) {
      EXPECT_LE(Limit(0.7 + depth, v), 0.0);
      EXPECT_GE(Limit(-0.4 - depth, v), 0.0);
    }
  }
  // Linear beyond the ramp; more on the way in than on the way out; let go when left fast enough.
  EXPECT_DOUBLE_EQ(Limit(0.8, 0.0), -50.0 * (0.8 - 0.7));
  EXPECT_LT(Limit(0.8, 1.0), Limit(0.8, 0.0));
  EXPECT_GT(Limit(0.8, -0.5), Limit(0.8, 0.0));
  EXPECT_EQ(Limit(0.8, -1.25), 0.0);
}

TEST(JointLimit, DerivativesEqualDifferencesAcrossTheRamp) {
  const double h = 1e-6;
  double largest = 0.0;
  for (const double x : {-0.5, -0.415, -0.401, 0.0, 0.701, 0.71, 0.72, 0.9}) {
    for (const double v : {-1.3, -1.0, 0.0, 0.4, 3.0}) {
      JointForce force;
      AddLimit(kLimit, x, v, &force);
      const double by_x = (Limit(x + h, v) - Limit(x - h, v)) / (2.0 * h);
      const double by_v = (Limit(x, v + h) - Limit(x, v - h)) / (2.0 * h);
      EXPECT_NEAR(force.by_pose(0, 0), by_x, 1e-5) << x << " " << v;
      EXPECT_NEAR(force.by_v(0), by_v, 1e-5) << x << " " << v;
      largest = std::max(largest, std::abs(by_x));
    }
  }
  EXPECT_GT(largest, 40.0);
}

TEST(BallSpring, IsTheGradientOfOneMinusCosine) {
  JointLaw law;
  law.stiffness = 3.0;
  law.rest = Vector3d(0.3, -0.9, 0.4);
  const Eigen::Quaterniond rest = ExpSo3(law.rest);
  const Vector3d axis = Vector3d(2.0, -1.0, 0.5).normalized();
  for (const double angle : {0.0, 1e-5, 0.5, 1.5, 3.0, 3.141592653589793}) {
    const Eigen::Quaterniond q = rest * ExpSo3(angle * axis);
    for (const double sign : {1.0, -1.0}) {  // both quaternions of one rotation
      const Eigen::Vector4d coefficients = sign * q.coeffs();
      JointForce force;
      AddBallSpring(law, coefficients.data(), &force);
      EXPECT_LT((force.tau + law.stiffness * std::sin(angle) * axis).norm(), 1e-14) << angle;
      for (int k = 0; k < 3; ++k) {
        const double h = 1e-5;
        const auto at = [&](double s) {
          const Eigen::Vector4d moved = (Eigen::Quaterniond(coefficients) * ExpSo3(s * Vector3d::Unit(k))).coeffs();
          JointForce f;
          AddBallSpring(law, moved.data(), &f);
          return f.tau;
        };
        const Vector3d slope = (at(h) - at(-h)) / (2.0 * h);
        EXPECT_LT((force.by_pose.col(k) - slope).norm(), 1e-8) << angle;
      }
    }
  }
}

TEST(Actuator, PositionSaturatesSmoothlyAndForceIsTheShareOfItsLimit) {
  const Actuator position{0, 0, ActuatorKind::kPosition, 2.0, 40.0, 0.5};
  const auto effort = [&](double x, double v, double u) {
    JointForce force;
    AddActuator(position, x, v, u, &force);
    return force.tau(0);
  };
  EXPECT_NEAR(effort(0.1, 0.2, 0.1001), 40.0 * 1e-4 - 0.5 * 0.2, 1e-4);  // linear while small
  EXPECT_NEAR(effort(0.0, 0.0, 10.0), 2.0, 1e-12);
  EXPECT_NEAR(effort(10.0, 0.0, 0.0), -2.0, 1e-12);
  const double h = 1e-6;
  for (const double u : {-0.1, 0.0, 0.03, 0.08}) {
    JointForce force;
    const double by_u = AddActuator(position, 0.02, 0.3, u, &force);
    EXPECT_NEAR(by_u, (effort(0.02, 0.3, u + h) - effort(0.02, 0.3, u - h)) / (2 * h), 1e-6);
    EXPECT_NEAR(force.by_pose(0, 0), (effort(0.02 + h, 0.3, u) - effort(0.02 - h, 0.3, u)) / (2 * h), 1e-6);
    EXPECT_NEAR(force.by_v(0), (effort(0.02, 0.3 + h, u) - effort(0.02, 0.3 - h, u)) / (2 * h), 1e-6);
    EXPECT_GT(by_u, 0.1);
  }
  JointForce force;
  EXPECT_EQ(AddActuator({0, 2, ActuatorKind::kForce, 2.5, 0.0, 0.0}, 0.0, 0.0, -0.4, &force), 2.5);
  EXPECT_EQ(force.tau, Vector3d(0.0, 0.0, -1.0));
}

}  // namespace joint_forces_test
}  // namespace knap
