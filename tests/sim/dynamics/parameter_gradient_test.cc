// The adjoint's gradient in every kind of parameter against differences, on random trees in free motion: placements,
// axes, inertias, joint laws, gravity, controls, initial state.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tests/sim/dynamics/random_world.h"

namespace knap {
namespace {

using test::MakeDirections;
using test::MakeWorldCase;
using test::RandomTree;
using test::World;
using test::WorldCase;
using test::WorldDirection;

TEST(ParameterGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    const WorldCase at = MakeWorldCase(&random);
    const TrajectoryGradient g = at.loss.Sweep(at.world);
    RC_ASSERT(g.finite && g.solvable);
    const std::vector<WorldDirection> directions = MakeDirections(&random, at.world, g);
    double largest = 0.0;
    for (const WorldDirection& d : directions) largest = std::max(largest, std::abs(d.slope));
    for (const WorldDirection& d : directions) {
      const auto loss = [&](double s) { return at.loss.Evaluate(d.move(at.world, s)); };
      double error = std::numeric_limits<double>::infinity();
      // Five-point central differences err by h⁴ times the fifth derivative, and by 1e-14/h of rounding.
      for (const double h : {4e-3, 2e-3, 1e-3, 5e-4}) {
        const double slope = (8.0 * (loss(h) - loss(-h)) - (loss(2.0 * h) - loss(-2.0 * h))) / (12.0 * h);
        error = std::min(error, std::abs(slope - d.slope));
        if (error < 1e-9 * largest) break;
      }
      if (error > 1e-7 * largest) RC_FAIL(d.kind + ": error " + std::to_string(error / largest) + " of the largest");
      // What vanishes in both says nothing.
      if (std::abs(d.slope) > 1e-4 * largest) ++compared[d.kind];
    }
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
    const TrajectoryGradient g = at.loss.Sweep(at.world);
    const std::vector<WorldDirection> directions = MakeDirections(&random, at.world, g);
    double slope = 0.0;
    for (const WorldDirection& d : directions) slope += d.slope;
    const auto move = [&](double s) {
      World world = at.world;
      for (const WorldDirection& d : directions) world = d.move(world, s);
      return at.loss.Evaluate(world);
    };
    const double start = move(0.0);
    double previous = 0.0;
    for (const double h : {1e-3, 5e-4, 2.5e-4, 1.25e-4}) {
      const double remainder = std::abs(move(h) - start - h * slope);
      EXPECT_GT(remainder, 1e-9 * h) << seed;
      if (previous > 0.0) {
        EXPECT_NEAR(std::log2(previous / remainder), 2.0, 0.1) << seed << " " << h;
      }
      previous = remainder;
    }
  }
}

}  // namespace
}  // namespace knap
