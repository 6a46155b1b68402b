// The adjoint's gradient in every kind of parameter, points of grips among them, on random trees whose bodies hold one
// another and are held by the world, some for a part of the time only.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <map>
#include <string>

#include "tests/sim/dynamics/random_world.h"

namespace knap {
namespace grip_gradient_test {

using test::CheckTaylorRemainderOfEveryKind;
using test::CompareEveryKind;
using test::MakeWorldCase;
using test::RandomTree;
using test::WorldCase;

WorldCase MakeHeldWorld(RandomTree* random) {
  WorldCase at = MakeWorldCase(random);
  for (TreeBody& body : at.world.bodies) body.law.limit = JointLimit{};
  const int n = random->tree.size();
  for (int i = 0; i < 3; ++i) {
    GripSpring grip;
    grip.holder = random->Pick(n);
    grip.held = (grip.holder + 1 + random->Pick(n - 1)) % n;
    grip.p_SA = random->Vec();
    grip.p_BP = random->Vec();
    grip.stiffness = 3.0 + 2.0 * random->U();
    grip.damping = 0.5 + 0.5 * random->U();
    if (i > 0) grip.limit = 2.0;
    if (i == 2) {
      grip.from = 0.04;
      grip.until = 0.16;
    }
    at.world.grips.push_back(grip);
  }
  return at;
}

TEST(GripGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    RC_PRE(random.tree.size() > 1 && random.tree.nv() > 0);
    CompareEveryKind(&random, MakeHeldWorld(&random), 1e-7, &compared);
  };
  EXPECT_TRUE(rc::check("gradients equal differences", property));
  for (const char* kind :
       {"point that holds", "point that is held", "initial pose", "initial rates", "placement",
        "placement of what does not move freely", "mass", "gravity", "force control", "revolute axis"}) {
    EXPECT_GE(compared[kind], 5) << kind;
  }
}

TEST(GripGradient, TaylorRemainderFallsAsTheSquare) {
  for (int seed = 0; seed < 10; ++seed) {
    RandomTree random(static_cast<std::uint64_t>(2000 + seed));
    if (random.tree.size() < 2) continue;
    const WorldCase at = MakeHeldWorld(&random);
    EXPECT_EQ(CheckTaylorRemainderOfEveryKind(&random, at), "") << seed;
  }
}

}  // namespace grip_gradient_test
}  // namespace knap
