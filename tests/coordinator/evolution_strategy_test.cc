#include "coordinator/optimizer/evolution_strategy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/coordinator/rosenbrock.h"

namespace knap {
namespace evolution_strategy_test {

using test::CalcRosenbrock;

using Vector = std::vector<double>;
using Function = std::function<ObjectiveValue(const Vector&)>;

MinimizerProblem MakeProblem(const Function& f, const Vector& lower, const Vector& upper, const Vector& start) {
  MinimizerProblem problem{.lower = lower, .upper = upper, .scale = {}, .start = start, .start_value = f(start)};
  for (std::size_t i = 0; i < start.size(); ++i) problem.scale.push_back(std::max(1e-3, upper[i] - lower[i]));
  return problem;
}

MinimizerOptions MakeOptions(const char* algorithm, int evaluations, std::uint64_t seed = 1) {
  return {.algorithm = algorithm,
          .max_evaluations = evaluations,
          .value_tolerance = 0.0,
          .step_tolerance = 0.0,
          .seed = seed};
}

// (x − c)ᵀ A (x − c) with principal axes off the coordinates' and a condition of 1e4.
ObjectiveValue CalcEllipsoid(const Vector& x) {
  const std::size_t n = x.size();
  ObjectiveValue out{.value = 0.0, .gradient = Vector(n, 0.0)};
  for (std::size_t k = 0; k < n; ++k) {
    // Orthonormal rows of the discrete cosine transform.
    const double weight = std::pow(10.0, 4.0 * static_cast<double>(k) / static_cast<double>(n - 1));
    double along = 0.0;
    Vector row(n);
    for (std::size_t i = 0; i < n; ++i) {
      row[i] =
          std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(n)) *
          std::cos(std::acos(-1.0) * (static_cast<double>(i) + 0.5) * static_cast<double>(k) / static_cast<double>(n));
      along += row[i] * (x[i] - 0.3);
    }
    out.value += weight * along * along;
    for (std::size_t i = 0; i < n; ++i) out.gradient[i] += 2.0 * weight * along * row[i];
  }
  return out;
}

// A bowl under a ripple whose slope is ten times the bowl's: a gradient leads to the next trough.
ObjectiveValue CalcRippled(const Vector& x) {
  ObjectiveValue out{.value = 0.0, .gradient = {}};
  for (const double xi : x) {
    const double d = xi - 0.7;
    out.value += d * d + 0.04 * (1.0 - std::cos(150.0 * d));
    out.gradient.push_back(2.0 * d + 6.0 * std::sin(150.0 * d));
  }
  return out;
}

class EvolutionTest : public testing::TestWithParam<const char*> {};

TEST_P(EvolutionTest, FindsMinimaInsideAndAtBounds) {
  const MinimizerProblem curved = MakeProblem(CalcRosenbrock, {-2.0, -2.0}, {2.0, 2.0}, {-1.2, 1.0});
  EXPECT_LE(Minimize(EachAlone(CalcRosenbrock), curved, MakeOptions(GetParam(), 4000)).value, 1e-8);
  const Vector low(8, -1.0), high(8, 1.0);
  const MinimizerProblem long_valley = MakeProblem(CalcEllipsoid, low, high, Vector(8, -0.9));
  EXPECT_LE(Minimize(EachAlone(CalcEllipsoid), long_valley, MakeOptions(GetParam(), 8000)).value, 1e-8);
  // Cut off at 0.2: the minimum lies in the corner of two bounds.
  const Function bowl = [](const Vector& x) {
    ObjectiveValue out{.value = 0.0, .gradient = {}};
    for (const double xi : x) {
      out.value += (xi - 0.3) * (xi - 0.3);
      out.gradient.push_back(2.0 * (xi - 0.3));
    }
    return out;
  };
  const MinimizerProblem cornered = MakeProblem(bowl, {-1.0, 0.35, -1.0}, {0.2, 1.0, 1.0}, {-0.5, 0.9, 0.9});
  const MinimizerResult corner = Minimize(EachAlone(bowl), cornered, MakeOptions(GetParam(), 3000));
  EXPECT_NEAR(corner.x[0], 0.2, 1e-4);
  EXPECT_NEAR(corner.x[1], 0.35, 1e-4);
  EXPECT_NEAR(corner.x[2], 0.3, 1e-4);
}

TEST_P(EvolutionTest, PassesRipplesThatCatchAGradient) {
  double caught = 0.0, passed = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Vector start(4, 0.1 + 0.013 * static_cast<double>(seed));
    const MinimizerProblem problem = MakeProblem(CalcRippled, Vector(4, 0.0), Vector(4, 1.0), start);
    caught += Minimize(EachAlone(CalcRippled), problem, MakeOptions("LD_LBFGS", 1600)).value;
    passed += Minimize(EachAlone(CalcRippled), problem, MakeOptions(GetParam(), 1600, seed)).value;
  }
  EXPECT_LT(passed, 0.1 * caught);
}

TEST_P(EvolutionTest, AsksForGenerationsInsideTheBoxAndForNoMoreThanIsAllowed) {
  const MinimizerProblem problem = MakeProblem(CalcRosenbrock, {-1.3, 0.5}, {2.0, 2.0}, {-1.2, 1.0});
  for (const int most : {1, 2, 17, 100}) {
    std::vector<std::size_t> sizes;
    const Objective f = [&](std::span<const Vector> points) {
      sizes.push_back(points.size());
      for (const Vector& x : points) {
        EXPECT_TRUE(-1.3 <= x[0] && x[0] <= 2.0 && 0.5 <= x[1] && x[1] <= 2.0);
      }
      return EachAlone(CalcRosenbrock)(points);
    };
    const MinimizerResult result = Minimize(f, problem, MakeOptions(GetParam(), most));
    EXPECT_EQ(result.evaluations, most);
    EXPECT_EQ(result.stop, MinimizerStop::kEvaluations);
    EXPECT_LE(result.value, problem.start_value.value);
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i) EXPECT_EQ(sizes[i], static_cast<std::size_t>(kGeneration));
  }
}

TEST_P(EvolutionTest, HasTheSameBitsAgainAndOthersWithAnotherSeed) {
  const MinimizerProblem problem = MakeProblem(CalcRosenbrock, {-2.0, -2.0}, {2.0, 2.0}, {-1.2, 1.0});
  std::set<Vector> found;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const MinimizerOptions options = MakeOptions(GetParam(), 200, seed);
    const MinimizerResult once = Minimize(EachAlone(CalcRosenbrock), problem, options);
    EXPECT_EQ(once.x, Minimize(EachAlone(CalcRosenbrock), problem, options).x);
    found.insert(once.x);
  }
  EXPECT_EQ(found.size(), 3u);
}

// Half of the box is refused, the better half: what is found is at its edge, and is accepted.
TEST_P(EvolutionTest, RetreatsFromWhatIsRefused) {
  const Function f = [](const Vector& x) {
    ObjectiveValue out{.value = x[0] + 0.1 * x[1] * x[1], .gradient = {1.0, 0.2 * x[1]}};
    out.accepted = x[0] >= 0.4;
    return out;
  };
  const MinimizerProblem problem = MakeProblem(f, {0.0, -1.0}, {1.0, 1.0}, {0.9, 0.5});
  const MinimizerResult result = Minimize(EachAlone(f), problem, MakeOptions(GetParam(), 1000));
  EXPECT_GT(result.rejected, 0);
  EXPECT_GE(result.x[0], 0.4);
  EXPECT_LE(result.x[0], 0.45);
  const Function never = [](const Vector&) { return ObjectiveValue{.accepted = false}; };
  const MinimizerResult none = Minimize(EachAlone(never), problem, MakeOptions(GetParam(), 100));
  EXPECT_EQ(none.x, problem.start);
  EXPECT_EQ(none.rejected, 99);
}

TEST_P(EvolutionTest, EndsWhereNothingChangesOrNothingCanMove) {
  const MinimizerProblem problem = MakeProblem(CalcRosenbrock, {-2.0, -2.0}, {2.0, 2.0}, {-1.2, 1.0});
  MinimizerOptions options = MakeOptions(GetParam(), 100000);
  options.step_tolerance = 1e-3;
  const MinimizerResult by_step = Minimize(EachAlone(CalcRosenbrock), problem, options);
  EXPECT_EQ(by_step.stop, MinimizerStop::kConverged);
  EXPECT_LT(by_step.evaluations, 5000);
  const Function flat = [](const Vector&) { return ObjectiveValue{.value = 1.0, .gradient = {0.0, 0.0}}; };
  options.value_tolerance = 1e-4;
  options.step_tolerance = 0.0;
  EXPECT_EQ(Minimize(EachAlone(flat), MakeProblem(flat, {-2.0, -2.0}, {2.0, 2.0}, {0.0, 0.0}), options).evaluations,
            1 + 10 * kGeneration);
  const MinimizerProblem held = MakeProblem(CalcRosenbrock, {-1.2, 1.0}, {-1.2, 1.0}, {-1.2, 1.0});
  EXPECT_EQ(Minimize(EachAlone(CalcRosenbrock), held, options).evaluations, 1);
}

// Where gradients are right they save evaluations.
TEST(EvolutionAlongGradients, DescendsFaster) {
  const MinimizerProblem problem = MakeProblem(CalcEllipsoid, Vector(12, -1.0), Vector(12, 1.0), Vector(12, -0.9));
  int faster = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto find = [&](const char* algorithm) {
      return Minimize(EachAlone(CalcEllipsoid), problem, MakeOptions(algorithm, 300, seed)).value;
    };
    faster += find(kEvolutionAlongGradient) < 0.5 * find(kEvolution) ? 1 : 0;
  }
  EXPECT_EQ(faster, 5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EvolutionTest, testing::Values(kEvolution, kEvolutionAlongGradient));

}  // namespace evolution_strategy_test
}  // namespace knap
