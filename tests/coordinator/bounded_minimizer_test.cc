#include "coordinator/optimizer/bounded_minimizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/coordinator/rosenbrock.h"

namespace knap {
namespace bounded_minimizer_test {

using test::CalcRosenbrock;

using Vector = std::vector<double>;
using Function = std::function<ObjectiveValue(const Vector&)>;

struct BoxProblem {
  const char* name;
  Function f;
  Vector lower, upper, start;
  double minimum;
  double tolerance;  // on the value reached
};

// Bound-constrained problems of W. Hock, K. Schittkowski, Test Examples for Nonlinear Programming Codes (1981), with
// their published minima; infinite bounds become ±10.
std::vector<BoxProblem> MakePublishedProblems() {
  const double sqrt3 = std::sqrt(3.0);
  return {
      {"Rosenbrock, minimum inside", CalcRosenbrock, {-2.0, -2.0}, {2.0, 2.0}, {-1.2, 1.0}, 0.0, 1e-8},
      {"HS1", CalcRosenbrock, {-10.0, -1.5}, {10.0, 10.0}, {-2.0, 1.0}, 0.0, 1e-8},
      // HS2 has a local minimum with value 4.9412 beside the global one at 0.0504; from its start both are published.
      {"HS2", CalcRosenbrock, {-10.0, 1.5}, {10.0, 10.0}, {-2.0, 1.5}, 4.941229318, 1e-6},
      {"HS3",
       [](const Vector& x) {
         const double e = x[1] - x[0];
         return ObjectiveValue{.value = x[1] + 1e-5 * e * e, .gradient = {-2e-5 * e, 1.0 + 2e-5 * e}};
       },
       {-10.0, 0.0},
       {10.0, 10.0},
       {10.0, 1.0},
       0.0,
       1e-6},
      {"HS4",
       [](const Vector& x) {
         return ObjectiveValue{.value = std::pow(x[0] + 1.0, 3) / 3.0 + x[1],
                               .gradient = {(x[0] + 1.0) * (x[0] + 1.0), 1.0}};
       },
       {1.0, 0.0},
       {10.0, 10.0},
       {1.125, 0.125},
       8.0 / 3.0,
       1e-8},
      {"HS5",
       [](const Vector& x) {
         const double e = x[0] - x[1];
         return ObjectiveValue{
             .value = std::sin(x[0] + x[1]) + e * e - 1.5 * x[0] + 2.5 * x[1] + 1.0,
             .gradient = {std::cos(x[0] + x[1]) + 2.0 * e - 1.5, std::cos(x[0] + x[1]) - 2.0 * e + 2.5}};
       },
       {-1.5, -3.0},
       {4.0, 3.0},
       {0.0, 0.0},
       -0.5 * sqrt3 - std::acos(-1.0) / 3.0,
       1e-8},
      {"HS38 (Colville)",
       [](const Vector& x) {
         const double a = x[1] - x[0] * x[0], b = x[3] - x[2] * x[2], p = x[1] - 1.0, q = x[3] - 1.0;
         return ObjectiveValue{.value = 100 * a * a + (1 - x[0]) * (1 - x[0]) + 90 * b * b + (1 - x[2]) * (1 - x[2]) +
                                        10.1 * (p * p + q * q) + 19.8 * p * q,
                               .gradient = {-400 * x[0] * a - 2 * (1 - x[0]), 200 * a + 20.2 * p + 19.8 * q,
                                            -360 * x[2] * b - 2 * (1 - x[2]), 180 * b + 20.2 * q + 19.8 * p}};
       },
       {-10, -10, -10, -10},
       {10, 10, 10, 10},
       {-3, -1, -3, -1},
       0.0,
       1e-6},
      {"HS45",
       [](const Vector& x) {
         ObjectiveValue v{.value = 2.0 - x[0] * x[1] * x[2] * x[3] * x[4] / 120.0};
         for (std::size_t i = 0; i < 5; ++i) {
           double product = 1.0;
           for (std::size_t j = 0; j < 5; ++j) product *= j == i ? 1.0 : x[j];
           v.gradient.push_back(-product / 120.0);
         }
         return v;
       },
       {0, 0, 0, 0, 0},
       {1, 2, 3, 4, 5},
       {0.5, 1, 1.5, 2, 2.5},
       1.0,
       1e-10},
  };
}

MinimizerProblem MakeProblem(const BoxProblem& box) {
  MinimizerProblem problem{
      .lower = box.lower, .upper = box.upper, .scale = {}, .start = box.start, .start_value = box.f(box.start)};
  for (std::size_t i = 0; i < box.start.size(); ++i) problem.scale.push_back(box.upper[i] - box.lower[i]);
  return problem;
}

// The first of the published problems.
MinimizerProblem MakeRosenbrockProblem() { return MakeProblem(MakePublishedProblems().front()); }

MinimizerOptions MakeTightOptions(const std::string& algorithm = "LD_LBFGS") {
  return {.algorithm = algorithm, .max_evaluations = 2000, .value_tolerance = 0.0, .step_tolerance = 0.0};
}

class PublishedProblems : public testing::TestWithParam<const char*> {};

TEST_P(PublishedProblems, AreSolvedInsideTheBox) {
  for (const BoxProblem& box : MakePublishedProblems()) {
    SCOPED_TRACE(box.name);
    const auto f = [&box](const Vector& x) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_LE(box.lower[i], x[i]);
        EXPECT_LE(x[i], box.upper[i]);
      }
      return box.f(x);
    };
    const MinimizerResult result = Minimize(EachAlone(f), MakeProblem(box), MakeTightOptions(GetParam()));
    double minimum = box.minimum;
    if (std::string(box.name) == "HS2" && result.value < 1.0) minimum = 0.0504261879;  // the other published minimum
    EXPECT_NEAR(result.value, minimum, box.tolerance) << GetName(result.stop) << ", " << result.evaluations;
    EXPECT_EQ(result.value, box.f(result.x).value);
  }
}

INSTANTIATE_TEST_SUITE_P(Algorithms, PublishedProblems, testing::Values("LD_LBFGS", "LD_SLSQP"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(BoundedMinimizerTest, DerivativeFreeAlgorithmsNeedNoGradient) {
  BoxProblem box{
      "sphere",   [](const Vector& x) {
                   return ObjectiveValue{.value = (x[0] - 0.3) * (x[0] - 0.3) + x[1] * x[1]}; },
      {-1, -1},   {1, 1},
      {0.9, 0.8}, 0.0,
      1e-8};
  for (const char* algorithm : {"LN_BOBYQA", "LN_COBYLA", "LN_SBPLX", "GN_CRS2_LM"}) {
    const MinimizerResult result = Minimize(EachAlone(box.f), MakeProblem(box), MakeTightOptions(algorithm));
    EXPECT_NEAR(result.value, 0.0, 1e-8) << algorithm;
    EXPECT_EQ(result.x, Minimize(EachAlone(box.f), MakeProblem(box), MakeTightOptions(algorithm)).x) << algorithm;
  }
}

// A trust region that fits the widest side has no room in a narrow one, and LN_BOBYQA then refuses the problem.
TEST(BoundedMinimizerTest, NarrowSidesLeaveRoomForTheFirstStep) {
  const BoxProblem box{"narrow",
                       [](const Vector& x) {
                         return ObjectiveValue{.value = (x[0] - 0.3) * (x[0] - 0.3) + (x[1] - 0.02) * (x[1] - 0.02)};
                       },
                       {-1, 0},
                       {1, 0.05},
                       {0.9, 0.0},
                       0.0,
                       1e-8};
  for (const char* algorithm : {"LN_BOBYQA", "LN_COBYLA", "LN_SBPLX"}) {
    EXPECT_NEAR(Minimize(EachAlone(box.f), MakeProblem(box), MakeTightOptions(algorithm)).value, 0.0, 1e-5)
        << algorithm;
  }
}

// Without scaling, LD_LBFGS steps by the bare gradient: 1e9 lands on the bound, 1e-9 counts as converged at the start.
TEST(BoundedMinimizerTest, FirstStepDoesNotDependOnTheUnitOfTheLoss) {
  for (const double unit : {1e-9, 1.0, 1e9}) {
    std::vector<Vector> asked;
    const auto f = [&](const Vector& x) {
      asked.push_back(x);
      return ObjectiveValue{.value = unit * (x[0] * x[0] + x[1] * x[1]),
                            .gradient = {2 * unit * x[0], 2 * unit * x[1]}};
    };
    MinimizerProblem problem{
        .lower = {-4, -4}, .upper = {4, 4}, .scale = {16, 16}, .start = {3, 1}, .start_value = f({3, 1})};
    MinimizerOptions options = MakeTightOptions();
    options.first_step = 0.25;
    const MinimizerResult result = Minimize(EachAlone(f), problem, options);
    ASSERT_GE(asked.size(), 2u);
    // The steepest coordinate moves by a quarter of the box's side of 8, the other in proportion.
    EXPECT_NEAR(asked[1][0], 3.0 - 2.0, 1e-9) << unit;
    EXPECT_NEAR(asked[1][1], 1.0 - 2.0 / 3.0, 1e-9) << unit;
    EXPECT_NEAR(result.x[0], 0.0, 1e-6) << unit;
    EXPECT_NEAR(result.x[1], 0.0, 1e-6) << unit;
  }
}

TEST(BoundedMinimizerTest, ReturnsTheBestPointSeenNotTheLast) {
  // A jagged function: its gradient lies, as a contact loss does across an event.
  std::vector<std::pair<double, Vector>> seen;
  const auto f = [&seen](const Vector& x) {
    const double value = (x[0] - 0.4) * (x[0] - 0.4) + 0.3 * std::abs(std::sin(40.0 * x[0])) + (x[1] > 0.6 ? 1.0 : 0.0);
    seen.emplace_back(value, x);
    return ObjectiveValue{.value = value, .gradient = {2.0 * (x[0] - 0.4), -1.0}};
  };
  const MinimizerProblem problem{
      .lower = {0, 0}, .upper = {1, 1}, .scale = {1, 1}, .start = {0.95, 0.5}, .start_value = f({0.95, 0.5})};
  MinimizerOptions options = MakeTightOptions();
  options.max_evaluations = 30;
  const MinimizerResult result = Minimize(EachAlone(f), problem, options);
  const auto best =
      std::min_element(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  EXPECT_EQ(result.value, best->first);
  EXPECT_EQ(result.x, best->second);
  EXPECT_LT(result.value, problem.start_value.value);
}

TEST(BoundedMinimizerTest, MaxEvaluationsIsExact) {
  for (int limit = 1; limit <= 40; ++limit) {
    int calls = 1;  // the caller's own at the start
    const auto f = [&calls](const Vector& x) {
      ++calls;
      return CalcRosenbrock(x);
    };
    const MinimizerProblem problem = MakeRosenbrockProblem();
    MinimizerOptions options = MakeTightOptions();
    options.max_evaluations = limit;
    const MinimizerResult result = Minimize(EachAlone(f), problem, options);
    EXPECT_LE(calls, limit);
    EXPECT_EQ(result.evaluations, calls);
    if (limit <= 20) {  // Rosenbrock takes more than 20 from here, so the limit is what ends it
      EXPECT_EQ(calls, limit);
      EXPECT_EQ(result.stop, MinimizerStop::kEvaluations);
    }
  }
}

TEST(BoundedMinimizerTest, ExceptionsOfTheObjectiveComeOutUnchanged) {
  struct OutOfWorkers : std::runtime_error {
    using runtime_error::runtime_error;
  };
  for (const char* algorithm : {"LD_LBFGS", "LD_SLSQP", "LN_BOBYQA", "LD_CCSAQ"}) {
    int calls = 0;
    const auto f = [&calls](const Vector& x) {
      if (++calls == 3) throw OutOfWorkers("no workers");
      return CalcRosenbrock(x);
    };
    const MinimizerProblem problem = MakeRosenbrockProblem();
    EXPECT_THROW(Minimize(EachAlone(f), problem, MakeTightOptions(algorithm)), OutOfWorkers) << algorithm;
    EXPECT_EQ(calls, 3) << algorithm;  // none after the exception
  }
}

// Beyond x0 = 0.5 the objective refuses to answer; the constrained minimum lies at that edge.
TEST(BoundedMinimizerTest, RejectedPointsPushTheSearchBack) {
  for (const char* algorithm : {"LD_LBFGS", "LD_SLSQP", "LD_CCSAQ", "LN_BOBYQA", "LN_SBPLX"}) {
    int rejected = 0;
    const auto f = [&rejected](const Vector& x) {
      if (x[0] > 0.5) {
        ++rejected;
        return ObjectiveValue{.accepted = false, .value = std::nan("")};
      }
      const double e = x[0] - 0.8;
      return ObjectiveValue{.value = e * e + x[1] * x[1], .gradient = {2 * e, 2 * x[1]}};
    };
    MinimizerProblem problem{
        .lower = {-1, -1}, .upper = {1, 1}, .scale = {2, 2}, .start = {-0.9, 0.7}, .start_value = f({-0.9, 0.7})};
    MinimizerOptions options = MakeTightOptions(algorithm);
    options.max_evaluations = 200;
    const MinimizerResult result = Minimize(EachAlone(f), problem, options);
    EXPECT_GT(rejected, 0) << algorithm;
    EXPECT_EQ(result.rejected, rejected) << algorithm;
    EXPECT_LE(result.x[0], 0.5) << algorithm;
    // From 3.38 at the start; 0.09 is the least possible.
    EXPECT_LT(result.value, 0.3) << algorithm;
  }
}

TEST(BoundedMinimizerTest, SurvivesAnObjectiveThatRejectsEverything) {
  for (const char* algorithm : {"LD_LBFGS", "LD_SLSQP", "LD_MMA", "LD_TNEWTON", "LD_VAR2", "LN_BOBYQA"}) {
    const auto f = [](const Vector&) { return ObjectiveValue{.accepted = false}; };
    MinimizerProblem problem{.lower = {-1, -1},
                             .upper = {1, 1},
                             .scale = {2, 2},
                             .start = {0.2, 0.7},
                             .start_value = {.value = 5.0, .gradient = {1.0, -2.0}}};
    const MinimizerResult result = Minimize(EachAlone(f), problem, MakeTightOptions(algorithm));
    EXPECT_EQ(result.x, problem.start) << algorithm;
    EXPECT_EQ(result.value, 5.0) << algorithm;
    EXPECT_EQ(result.rejected, result.evaluations - 1) << algorithm;
  }
}

TEST(BoundedMinimizerTest, BlockedOrFlatStartsConvergeAtOnce) {
  const auto never = [](const Vector&) -> ObjectiveValue { throw std::logic_error("asked"); };
  MinimizerProblem problem{.lower = {0, 0},
                           .upper = {1, 1},
                           .scale = {1, 1},
                           .start = {0, 1},
                           .start_value = {.value = 3.0, .gradient = {2.0, -1.0}}};  // both slopes point outwards
  EXPECT_EQ(Minimize(EachAlone(never), problem, MakeTightOptions()).stop, MinimizerStop::kConverged);
  problem.start_value.gradient = {0.0, 0.0};
  EXPECT_EQ(Minimize(EachAlone(never), problem, MakeTightOptions()).evaluations, 1);
  problem.upper = problem.lower = problem.start = {0.5, 0.5};  // a box without width
  problem.start_value.gradient = {1.0, 1.0};
  EXPECT_EQ(Minimize(EachAlone(never), problem, MakeTightOptions()).x, problem.start);
}

TEST(BoundedMinimizerTest, TolerancesEndTheSearch) {
  const MinimizerProblem problem = MakeRosenbrockProblem();
  const int tight = Minimize(EachAlone(CalcRosenbrock), problem, MakeTightOptions()).evaluations;
  MinimizerOptions loose = MakeTightOptions();
  loose.value_tolerance = 0.5;
  const MinimizerResult by_value = Minimize(EachAlone(CalcRosenbrock), problem, loose);
  EXPECT_EQ(by_value.stop, MinimizerStop::kConverged);
  EXPECT_LT(by_value.evaluations, tight);
  loose.value_tolerance = 0.0;
  loose.step_tolerance = 0.05;
  const MinimizerResult by_step = Minimize(EachAlone(CalcRosenbrock), problem, loose);
  EXPECT_EQ(by_step.stop, MinimizerStop::kConverged);
  EXPECT_LT(by_step.evaluations, tight);
}

TEST(BoundedMinimizerTest, BadInputIsNamed) {
  EXPECT_THROW(CheckMinimizerAlgorithm("LD_LBFG"), std::invalid_argument);
  EXPECT_THROW(CheckMinimizerAlgorithm("AUGLAG"), std::invalid_argument);
  EXPECT_THROW(CheckMinimizerAlgorithm("G_MLSL"), std::invalid_argument);
  EXPECT_THROW(CheckMinimizerAlgorithm("LN_NEWUOA_BOUND"), std::invalid_argument);  // not in one dimension
  for (const char* algorithm :
       {"LD_LBFGS", "LD_SLSQP", "LD_MMA", "LD_TNEWTON", "LN_COBYLA", "LN_BOBYQA", "GN_DIRECT_L"}) {
    EXPECT_NO_THROW(CheckMinimizerAlgorithm(algorithm));
  }
  EXPECT_TRUE(UsesGradient("LD_LBFGS"));
  EXPECT_FALSE(UsesGradient("GN_DIRECT_L"));
  MinimizerProblem problem{
      .lower = {0}, .upper = {1}, .scale = {1}, .start = {2}, .start_value = {.value = 0.0, .gradient = {1.0}}};
  const auto f = [](const Vector&) { return ObjectiveValue{.value = 0.0, .gradient = {1.0, 2.0}}; };
  EXPECT_THROW(Minimize(EachAlone(f), problem, {}), std::invalid_argument);  // start outside
  problem.start = {0.5};
  EXPECT_THROW(Minimize(EachAlone(f), problem, {}), std::invalid_argument);  // the gradient has two values
}

}  // namespace bounded_minimizer_test
}  // namespace knap
