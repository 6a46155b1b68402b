// The adjoint's gradient in every kind of parameter against differences, on random trees in free motion: placements,
// axes, inertias, joint laws, gravity, controls, initial state.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <map>
#include <string>

#include "tests/sim/dynamics/random_world.h"

namespace knap {
namespace parameter_gradient_test {

using test::CheckTaylorRemainderOfEveryKind;
using test::CompareEveryKind;
using test::MakeWorldCase;
using test::RandomTree;
using test::WorldCase;

TEST(ParameterGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    CompareEveryKind(&random, MakeWorldCase(&random), 1e-7, &compared);
  };
  EXPECT_TRUE(rc::check("gradients equal differences", property));
  for (const char* kind :
       {"initial pose", "initial rates", "gravity", "force control", "position control", "placement",
        "placement of what does not move freely", "mass", "first moment", "rotational inertia", "damping", "stiffness",
        "ball stiffness", "rest", "rest of a ball", "revolute axis", "prismatic axis"}) {
    EXPECT_GE(compared[kind], 5) << kind;
  }
}

TEST(ParameterGradient, TaylorRemainderFallsAsTheSquare) {
  for (int seed = 0; seed < 20; ++seed) {
    RandomTree random(static_cast<std::uint64_t>(1000 + seed));
    WorldCase at = MakeWorldCase(&random);
    // A limit is twice differentiable only: at its ends the remainder is of order 2 without a constant rate.
    for (TreeBody& body : at.world.bodies) body.law.limit = JointLimit{};
    EXPECT_EQ(CheckTaylorRemainderOfEveryKind(&random, at), "") << seed;
  }
}

}  // namespace parameter_gradient_test
}  // namespace knap
