// Gradients through collisions against the closed forms of rigid, elastic ones: one bounce, a ball between ground and
// wall, two balls. Contact is soft, so they are met as its duration vanishes: errors fall with stiffness and are small.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/gradient/adjoint.h"
#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace contact_oracle_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::PairScene;

constexpr double kRadius = 0.01;
constexpr double kMass = 0.0042;

ContactMaterial MakeElastic(double stiffness) { return {stiffness, 0.0, 0.0, 0.0, 1e-3, 0.0}; }

int AddBall(PairScene* scene, const Vector3d& p, const Vector3d& v) {
  return scene->AddFree(kMass, Vector3d::Constant(0.4 * kMass * kRadius * kRadius), p, Quaterniond::Identity(), v,
                        Vector3d(1.0, 2.0, 3.0));
}

// d(direction · p_body at the end)/d(initial positions and velocities of all balls, six numbers a ball: pose, rates).
struct Gradient {
  VectorXd pose;
  VectorXd rates;
};

// Steps far shorter than a contact: the discrete restitution varies with where in a step a contact begins, a little,
// but over a very short distance.
Gradient Calc(const PairScene& scene, int body, const Vector3d& direction, double duration, double step) {
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  const SimulationOptions options = test::MakeOptions(step, duration, 2);
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0(), scene.v0(), options);
  EXPECT_TRUE(t.certificate.converged);
  EXPECT_GE(t.certificate.contact_onsets, 1);
  StateCotangent at;
  at.state = t.size() - 1;
  at.body = body;
  at.p_W = direction;
  const TrajectoryGradient g = SweepAdjoint(t, {at}, &dynamics, &contacts);
  EXPECT_TRUE(g.finite && g.solvable);
  return {g.pose0, g.v0};
}

// calc_error(stiffness, step) halves at least from the first to the second, and ends below `bound`.
template <class CalcError>
void ExpectErrorFalls(const CalcError& calc_error, double soft, double stiff, double stiff_step, double bound) {
  const double before = calc_error(soft, 1e-5);
  const double error = calc_error(stiff, stiff_step);
  EXPECT_LT(error, 0.5 * before);
  EXPECT_LT(error, bound);
}

TEST(ContactOracle, OneBounce) {
  const double z0 = kRadius + 0.02;
  const double v0 = -0.5;
  const double T = 0.08;
  const double g = 9.81;
  // Falls for t1, leaves with the speed it came with: z(T) = r + u s − g s²/2, u² = v0² + 2 g (z0 − r), s = T − t1.
  const auto height = [&](double z, double v) {
    const double u = std::sqrt(v * v + 2 * g * (z - kRadius));
    const double s = T - (v + u) / g;
    return kRadius + u * s - 0.5 * g * s * s;
  };
  const double by_z = (height(z0 + 1e-6, v0) - height(z0 - 1e-6, v0)) / 2e-6;
  const double by_v = (height(z0, v0 + 1e-6) - height(z0, v0 - 1e-6)) / 2e-6;
  const auto calc_error = [&](double stiffness, double step) {
    PairScene scene;
    const int ground = scene.AddFixed();
    const int ball = AddBall(&scene, Vector3d(0, 0, z0), Vector3d(0, 0, v0));
    scene.Touch(ball, SphereGeometry{kRadius, Vector3d::Zero()}, ground, HalfSpaceGeometry{}, MakeElastic(stiffness));
    const Gradient gradient = Calc(scene, ball, Vector3d::UnitZ(), T, step);
    return std::abs(gradient.pose(2) - by_z) / std::abs(by_z) + std::abs(gradient.rates(2) - by_v) / std::abs(by_v);
  };
  ExpectErrorFalls(calc_error, 1e7, 1e10, 2e-6, 0.15);
}

TEST(ContactOracle, BallOnGroundAndWall) {
  const double T = 0.1;
  const auto calc_error = [&](double stiffness, double step) {
    PairScene scene;
    scene.tree.gravity.setZero();
    const int ground = scene.AddFixed();
    Pose X_WV;  // solid beyond x = 0.04: its z axis looks back
    X_WV.R = Eigen::AngleAxisd(-0.5 * std::acos(-1.0), Vector3d::UnitY()).toRotationMatrix();
    X_WV.p.x() = 0.04;
    const int wall = scene.AddFixed(X_WV);
    const int ball = AddBall(&scene, Vector3d(0.0, 0.0, 0.025), Vector3d(0.6, 0.1, -0.5));
    const SphereGeometry sphere{kRadius, Vector3d::Zero()};
    scene.Touch(ball, sphere, ground, HalfSpaceGeometry{}, MakeElastic(stiffness));
    scene.Touch(ball, sphere, wall, HalfSpaceGeometry{}, MakeElastic(stiffness));
    double error = 0.0;
    for (const int axis : {0, 2}) {
      // The coordinate is mirrored: x(T) = constant − x0 − v T.
      const Gradient gradient = Calc(scene, ball, Vector3d::Unit(axis), T, step);
      error += std::abs(gradient.pose(axis) + 1.0) + std::abs(gradient.rates(axis) + T) / T;
    }
    return error;
  };
  ExpectErrorFalls(calc_error, 1e7, 1e9, 4e-6, 0.1);
}

TEST(ContactOracle, TwoBallsExchangeTheirMotions) {
  const double T = 0.1;
  const auto calc_error = [&](double stiffness, double step) {
    PairScene scene;
    scene.tree.gravity.setZero();
    const int first = AddBall(&scene, Vector3d(0.0, 0.0, 0.0), Vector3d(0.5, 0.0, 0.0));
    const int second = AddBall(&scene, Vector3d(0.04, 0.0, 0.0), Vector3d::Zero());
    const SphereGeometry sphere{kRadius, Vector3d::Zero()};
    scene.Touch(first, sphere, second, sphere, MakeElastic(stiffness));
    // x2(T) = x1 + 2 r + v1 T and x1(T) = x2 − 2 r + v2 T.
    const Gradient of_second = Calc(scene, second, Vector3d::UnitX(), T, step);
    const Gradient of_first = Calc(scene, first, Vector3d::UnitX(), T, step);
    return std::abs(of_second.pose(0) - 1.0) + std::abs(of_second.pose(6)) + std::abs(of_second.rates(0) - T) / T +
           std::abs(of_second.rates(6)) / T + std::abs(of_first.pose(0)) + std::abs(of_first.pose(6) - 1.0) +
           std::abs(of_first.rates(0)) / T + std::abs(of_first.rates(6) - T) / T;
  };
  ExpectErrorFalls(calc_error, 1e6, 4e8, 1e-6, 0.05);
}

}  // namespace contact_oracle_test
}  // namespace knap
