// The mechanism of Flipping does what its benchmark is named after: the finger pushes the box over.
#include "tests/sim/dynamics/flipping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace knap {
namespace flipping_test {

constexpr double kQuarterTurn = 0.5 * std::numbers::pi;

TEST(Flipping, TheFingerPushesTheBoxOverItsHinge) {
  const test::Flipping flipping = test::MakeFlipping();
  Dynamics dynamics(flipping.tree);
  ContactModel contacts(flipping.contacts);
  const Trajectory t =
      Simulator(&dynamics, &contacts).Run(flipping.q0, flipping.v0, flipping.options, flipping.controls);
  ASSERT_TRUE(t.certificate.converged);
  EXPECT_LE(t.certificate.worst_residual, flipping.options.newton_tolerance);
  const int end = t.size() - 1;
  EXPECT_GT(t.last_touched()[flipping.finger_on_box], 0.2);
  // It lies on its far face, which its weight of 2.1 N presses into the floor by less than 0.1 mm, and hardly rocks.
  EXPECT_NEAR(t.q(end)(flipping.hinge), kQuarterTurn, 5e-3);
  EXPECT_LT(std::abs(t.v(end)(flipping.tree.bodies()[flipping.box].v_start)), 5e-3);
  for (int k = 0; k <= end; ++k) EXPECT_GT(t.q(k)(flipping.hinge), -1e-3) << k;
}

}  // namespace flipping_test
}  // namespace knap
