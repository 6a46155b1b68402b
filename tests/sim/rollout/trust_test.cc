// Rollouts whose bodies press or pass through one another say so by name and are no success, however well they end.
#include <gtest/gtest.h>

#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace trust_test {

// A ball flies along y through a plate, and its end beyond it is what success asks for.
RolloutOutput ThrowAtPlate(double speed, const std::string& stiffness, const std::string& rollout,
                           const std::string& more = "") {
  const std::string text =
      "schema: 2\nname: throw\ngravity: [0 m/s^2, 0 m/s^2, 0 m/s^2]\n"
      "bodies:\n"
      "  - {name: plate, joint: {type: fixed}, shapes: [{type: box, size: [60 mm, 2 mm, 60 mm]}]}\n"
      "  - name: ball\n"
      "    joint: {type: free}\n"
      "    shapes: [{type: sphere, radius: 5 mm}]\n"
      "    inertia: {type: solid, mass: 4 g}\n"
      "    initial: {position: [1 mm, -30 mm, 2 mm], velocity: [0 m/s, " +
      std::to_string(speed) +
      " m/s, 0 m/s]}\n"
      "contacts: [{bodies: [ball, plate], stiffness: " +
      stiffness +
      "}]\n"
      "rollout: {" +
      rollout +
      "}\n"
      "signals: [{name: x, type: position, body: ball, axis: x}, {name: y, type: position, body: ball, axis: y}]\n"
      "loss: {task: [{signals: [x], when: {type: crossing, signal: y, at: 20 mm}, margin: 50 mm}]}\n"
      "success: {type: within, signals: [x], above: -50 mm, below: 50 mm, when: {type: crossing, signal: y, at: 20 "
      "mm}}\n"
      "learning: {variations: 1, batch: 1}\n" +
      more;
  RolloutModel model({{kScenarioFileName, text}});
  RolloutInput input;
  input.want_gradient = false;
  return model.Run(input, {});
}

TEST(TrustTest, AHardPlateThrowsTheBallBack) {
  const RolloutOutput out = ThrowAtPlate(0.2, "1e9 N/m^3", "horizon: 400 ms");
  EXPECT_TRUE(out.distrust.empty());
  EXPECT_FALSE(out.success);
  EXPECT_GT(out.certificate.penetration, 0.0);
  EXPECT_LT(out.certificate.penetration, 0.5);
  EXPECT_GT(out.certificate.largest_force, 0.0);
}

TEST(TrustTest, WhatPressesThroughIsNoSuccess) {
  const RolloutOutput out = ThrowAtPlate(2.0, "1e5 N/m^3", "horizon: 80 ms");
  ASSERT_EQ(out.distrust.size(), 1u);
  EXPECT_NE(out.distrust[0].find("ball and plate press into one another"), std::string::npos) << out.distrust[0];
  EXPECT_FALSE(out.success);
  // Who allows it gets it.
  const RolloutOutput allowed = ThrowAtPlate(2.0, "1e5 N/m^3", "horizon: 80 ms", "trust: {penetration: 100}\n");
  EXPECT_TRUE(allowed.distrust.empty());
  EXPECT_TRUE(allowed.success);
}

// In steps of 4 ms the ball is 40 mm farther each time: no state sees it touch.
TEST(TrustTest, AFixedStepOverThePlateIsCut) {
  const RolloutOutput out = ThrowAtPlate(10.0, "1e9 N/m^3", "horizon: 8 ms, step: 4 ms, integrator: bdf1");
  EXPECT_GT(out.certificate.subdivided_steps, 0);
  EXPECT_FALSE(out.success) << "it was thrown back, or is not to be trusted";
}

TEST(TrustTest, WhatPassesEvenInTheLeastStepIsNamed) {
  const RolloutOutput out = ThrowAtPlate(1e5, "1e9 N/m^3", "horizon: 8 ms, step: 4 ms, integrator: bdf1");
  ASSERT_EQ(out.distrust.size(), 1u);
  EXPECT_EQ(out.distrust[0], "ball and plate pass through one another");
  EXPECT_FALSE(out.success);
}

// Such a tolerance asks for thousands of times as many steps as usual once forces change.
TEST(TrustTest, StepsThatLeadNowhereAreGivenUpAndTheirPlaceNamed) {
  const RolloutOutput out = ThrowAtPlate(0.2, "1e9 N/m^3", "horizon: 400 ms, tolerance: 1e-14");
  EXPECT_FALSE(out.certificate.converged);
  EXPECT_FALSE(out.gradient_reliable);
  EXPECT_FALSE(out.success);
  // The ball's surface reaches the plate's after (30 − 5 − 1) mm at 0.2 m/s: at 0.12 s.
  ASSERT_EQ(out.distrust.size(), 1u);
  EXPECT_EQ(out.distrust[0].rfind("it was given up as ever shorter steps led nowhere while ball and plate pressed "
                                  "hardest, at 0.120",
                                  0),
            0u)
      << out.distrust[0];
}

}  // namespace trust_test
}  // namespace knap
