// configs/winding.yaml: the rope starts clear of every spool, gravity comes from everywhere alike, losses and success
// say what they mean, and the gradient is that of the loss.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/rollout/scene_design.h"
#include "sim/scenarios/apply_variation.h"
#include "tests/sim/rollout/winding_scene.h"

namespace knap {
namespace winding_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::Build;
using test::LoadWinding;
using test::MakeTheta;

TEST(Winding, TheRopeStartsClearOfEverySpool) {
  const RolloutModel rollout = LoadWinding({});
  const std::vector<DesignParameter>& parameters = rollout.scene().design->parameters;
  ASSERT_EQ(parameters.size(), 8u);
  std::mt19937_64 generator(1);
  for (int trial = 0; trial < 60; ++trial) {
    VectorXd theta(8);
    for (int i = 0; i < 8; ++i) {
      // Half of them at corners of the bounds.
      double share = std::uniform_real_distribution<double>(0.0, 1.0)(generator);
      if (trial % 2 == 0) share = std::round(share);
      theta(i) = parameters[i].lower + share * (parameters[i].upper - parameters[i].lower);
    }
    const SceneModel model = Build(rollout, rollout.scene(), theta);
    Dynamics dynamics(model.tree);
    ContactModel contacts(model.contacts);
    dynamics.CalcKinematics(model.q0, model.v0, VectorXd::Zero(model.tree.nv()), 0.0);
    contacts.AddWrenches(&dynamics);
    for (const ContactReport& report : contacts.reports()) EXPECT_FALSE(report.active) << theta.transpose();
  }
}

TEST(Winding, TheRopeIsWoundAroundTheSpool) {
  const RolloutModel rollout = LoadWinding({});
  const SceneModel model = Build(rollout, rollout.scene(), rollout.initial_theta());
  const std::vector<int>& links = model.links.at("rope");
  ASSERT_EQ(links.size(), 15u);
  EXPECT_EQ(model.tree.nv(), 48);
  Dynamics dynamics(model.tree);
  dynamics.CalcKinematics(model.q0, model.v0, VectorXd::Zero(48), 0.0);
  double turned = 0.0;
  Vector3d before = Vector3d::Zero();
  for (int i = 0; i <= 15; ++i) {
    const Pose& X = dynamics.kinematics()[links[std::min(i, 14)]].X_WB;
    const Vector3d joint = i < 15 ? X.p : Vector3d(X * Vector3d(0.03, 0.0, 0.0));
    // On a square of 60 mm, within the middle part.
    EXPECT_NEAR(joint.tail<2>().cwiseAbs().maxCoeff(), 0.03, 1e-4) << i;
    EXPECT_LT(std::abs(joint.x()) + 0.004, 0.015) << i;
    if (i > 0) {
      EXPECT_NEAR((joint - before).norm(), 0.03, 1e-12);
      turned += std::atan2(before.y() * joint.z() - before.z() * joint.y(), before.tail<2>().dot(joint.tail<2>()));
    }
    before = joint;
  }
  EXPECT_NEAR(turned / (2.0 * std::numbers::pi), 1.875, 1e-3);
}

TEST(Winding, GravityComesFromEverywhereAlike) {
  const RolloutModel rollout = LoadWinding({});
  std::mt19937_64 generator(2);
  const auto draw = [&](int i) {
    const auto& d = std::get<UniformDistribution>(rollout.scene().variation[i].distribution);
    return std::uniform_real_distribution<double>(d.lower, d.upper)(generator);
  };
  const DesignedShapes shapes = rollout.design()->CalcShapes(rollout.initial_theta());
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 4000;
  for (int n = 0; n < kDraws; ++n) {
    Scene varied = rollout.scene();
    ApplyVariation(varied, std::vector{draw(0), draw(1)});
    const Vector3d g = BuildModel(varied, shapes).tree.gravity;
    EXPECT_NEAR(g.norm(), 9.81, 1e-12);
    mean += g / 9.81 / kDraws;
    second += g * g.transpose() / (9.81 * 9.81) / kDraws;
  }
  // Four standard deviations of a mean of unit vectors, and of their squares.
  EXPECT_LT(mean.norm(), 4.0 / std::sqrt(kDraws));
  EXPECT_LT((second - Eigen::Matrix3d::Identity() / 3.0).norm(), 4.0 / std::sqrt(kDraws));
}

TEST(Winding, APrismLosesTheRopeAlongItsAxisAndWideEndsHoldIt) {
  RolloutModel rollout = LoadWinding({});
  RolloutInput input;
  input.variation = {0.0, -0.5};  // 30° below the spool's axis, more than the angle of friction
  input.want_gradient = false;
  input.theta = MakeTheta(rollout, 0.05);
  const RolloutOutput prism = rollout.Run(input, {});
  ASSERT_TRUE(prism.certificate.converged);
  EXPECT_FALSE(prism.success);
  // It slides off and falls: by less than freely, Σ (g t²/2)² over 50 samples, and far more than not at all.
  double free = 0.0;
  for (int n = 1; n <= 50; ++n) free += std::pow(0.5 * 9.81 * std::pow(0.02 * n, 2), 2);
  EXPECT_LT(prism.loss, free);
  EXPECT_GT(prism.loss, 0.05 * free);
  input.theta = MakeTheta(rollout, 0.12);
  const RolloutOutput spool = rollout.Run(input, {});
  ASSERT_TRUE(spool.certificate.converged);
  EXPECT_TRUE(spool.success);
  EXPECT_LT(spool.loss, 0.01 * prism.loss);
}

TEST(Winding, GradientsEqualDifferences) {
  // Long enough for the rope to have fallen onto the spool and to slide.
  RolloutModel rollout =
      LoadWinding({"rollout.horizon=0.1 s", "loss.task[0].when.until=0.1 s", "loss.distillation[0].when.until=0.1 s",
                   "success.of[1].when.from=0 s", "rollout.newton_tolerance=1e-12"});
  RolloutInput input;
  input.variation = {0.7, -0.6};
  input.theta = MakeTheta(rollout, 0.07);
  input.theta(2) = 0.045;
  input.theta(5) = 0.042;
  test::ExpectGradientsEqualDifferences(&rollout, input, test::MakeTheta(rollout, 0.06), {1e-6, 6e-8, 4e-9}, 1e-4);
}

// Whether a step is cut hangs on the design, and with it the loss: the certificate says that this gradient is doubtful.
TEST(Winding, AGradientAcrossACutStepIsNotSmooth) {
  for (const bool few : {false, true}) {
    RolloutModel rollout =
        LoadWinding({"rollout.horizon=0.1 s", "loss.task[0].when.until=0.1 s", "loss.distillation[0].when.until=0.1 s",
                     "success.of[1].when.from=0 s", "rollout.newton_tolerance=1e-12",
                     few ? "rollout.newton_max_iterations=1" : "rollout.newton_max_iterations=30"});
    RolloutInput input;
    input.variation = {0.7, -0.6};
    input.theta = MakeTheta(rollout, 0.07);
    const RolloutOutput out = rollout.Run(input, {});
    ASSERT_TRUE(out.certificate.converged && out.certificate.finite);
    EXPECT_EQ(out.certificate.subdivided_steps > 0, few);
    EXPECT_EQ(out.gradient_reliable, !few);
    const double g = (out.gradient.array() * rollout.design()->ranges().array()).abs().maxCoeff();
    const GradientDemand& demand = rollout.scene().gradient;
    EXPECT_LT(out.loss_rounding, demand.step * demand.tolerance * g);
  }
}

TEST(Winding, ARopeMayTouchItself) {
  const RolloutModel rollout = LoadWinding({});
  Scene scene = rollout.scene();
  Contact own = scene.contacts[0];
  own.bodies = {"rope", "rope"};
  scene.contacts.push_back(own);
  const SceneModel model = Build(rollout, scene, rollout.initial_theta());
  // 15 with the spool; of 105 pairs of links, 14 are neighbours.
  EXPECT_EQ(model.contacts.size(), 15u + 91u);
}

}  // namespace winding_test
}  // namespace knap
