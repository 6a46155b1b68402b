// Grips against closed forms: a damped oscillation, the sag of a weight, the pull from afar, a mass carried around, and
// the moment when one lets go.
#include "sim/contact/grip.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace grip_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMass = 0.2;

// A small body at p, held at its centre by the world's point 0; returns the path of its centre.
std::vector<Vector3d> RunMass(const GripSpring& spring, const Vector3d& gravity, const Vector3d& p, const Vector3d& v,
                              double step, int steps, PrescribedMotion holder = {}) {
  test::PairScene scene;
  scene.tree.gravity = gravity;
  GripSpring grip = spring;
  grip.holder = holder ? scene.AddPrescribed(std::move(holder)) : scene.AddFixed();
  grip.held = scene.AddFree(kMass, Vector3d::Constant(1e-5), p, Quaterniond::Identity(), v, Vector3d::Zero());
  Dynamics dynamics(scene.tree);
  ContactModel contacts({}, {grip});
  SimulationOptions options;
  options.step = step;
  options.steps = steps;
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0(), scene.v0(), options);
  EXPECT_TRUE(t.certificate.converged);
  EXPECT_EQ(t.certificate.subdivided_steps, 0);
  std::vector<Vector3d> path;
  for (int k = 0; k < t.size(); ++k) path.push_back(t.q(k).head<3>());
  return path;
}

TEST(Grip, ADampedOscillationConvergesToItsClosedFormWithOrderTwo) {
  GripSpring grip;
  grip.stiffness = 20.0;
  grip.damping = 0.4;
  const double decay = grip.damping / (2.0 * kMass);
  const double omega = std::sqrt(grip.stiffness / kMass - decay * decay);
  double before = 0.0;
  for (const int steps : {200, 400, 800, 1600}) {
    const double step = 1.0 / steps;
    const std::vector<Vector3d> path = RunMass(grip, Vector3d::Zero(), {0.1, 0, 0}, Vector3d::Zero(), step, steps);
    const double x = 0.1 * std::exp(-decay) * (std::cos(omega) + decay / omega * std::sin(omega));
    const double error = std::abs(path.back().x() - x);
    EXPECT_LT(path.back().tail<2>().norm(), 1e-12);
    if (before > 0.0) {
      EXPECT_NEAR(std::log2(before / error), 2.0, 0.2);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-4 * 0.1);
}

TEST(Grip, AWeightSagsAsFarAsTheLimitedSpringSays) {
  GripSpring grip;
  grip.stiffness = 100.0;
  grip.damping = 5.0;
  grip.limit = 3.0;
  const double weight = kMass * 9.81;
  const double sag = weight / grip.stiffness / std::sqrt(1.0 - std::pow(weight / grip.limit, 2));
  const std::vector<Vector3d> path = RunMass(grip, {0, 0, -9.81}, Vector3d::Zero(), Vector3d::Zero(), 5e-3, 2000);
  EXPECT_NEAR(path.back().z(), -sag, 1e-9);
}

TEST(Grip, PullsWithItsLimitFromAfar) {
  GripSpring grip;
  grip.stiffness = 1e4;
  grip.limit = 3.0;
  for (const double distance : {1.0, 3.0}) {
    const GripForce force = CalcGripForce(grip, Vector3d(0, distance, 0), Vector3d::Zero());
    EXPECT_LT(force.f.y(), -grip.limit * (1.0 - 1e-7));
    EXPECT_GT(force.f.y(), -grip.limit);
  }
  // Half a second of it: F t²/2m.
  const std::vector<Vector3d> path = RunMass(grip, Vector3d::Zero(), {0, 3, 0}, Vector3d::Zero(), 1e-3, 500);
  EXPECT_NEAR(path.back().y(), 3.0 - 0.5 * grip.limit / kMass * 0.25, 0.002);
}

// The damping is against the holder's own frame: it leaves what turns along with that alone, at the radius where the
// spring is the centripetal force.
TEST(Grip, CarriesAMassAround) {
  GripSpring grip;
  grip.p_SA = {0.3, 0.0, 0.0};
  grip.stiffness = 50.0;
  grip.damping = 2.0;
  const double omega = 5.0;
  const double radius = grip.stiffness * 0.3 / (grip.stiffness - kMass * omega * omega);
  const auto turn = [&](double time) {
    PrescribedState state;
    state.X_FB.R = Eigen::AngleAxisd(omega * time, Vector3d::UnitZ()).toRotationMatrix();
    state.V(2) = omega;
    return state;
  };
  const std::vector<Vector3d> path =
      RunMass(grip, Vector3d::Zero(), {radius, 0, 0}, {0, omega * radius, 0}, 5e-4, 2000, turn);
  EXPECT_LT((path.back() - radius * Vector3d(std::cos(omega), std::sin(omega), 0)).norm(), 1e-4 * radius);
}

TEST(Grip, LetsGo) {
  GripSpring grip;
  grip.stiffness = 1e3;
  grip.damping = 20.0;
  grip.until = 0.5;
  const double step = 2e-3;
  const std::vector<Vector3d> path =
      RunMass(grip, {0, 0, -9.81}, {0, 0, -kMass * 9.81 / 1e3}, Vector3d::Zero(), step, 500);
  EXPECT_NEAR(path[250].z(), path[0].z(), 1e-9);
  // The steps after 0.5 s fall freely: BDF2 is exact for a parabola but for its start, of order one.
  EXPECT_NEAR(path[500].z() - path[250].z(), -0.5 * 9.81 * 0.25, 9.81 * 0.5 * step);
  EXPECT_LT(path[251].z(), path[250].z() - 1e-6);
}

}  // namespace grip_test
}  // namespace knap
