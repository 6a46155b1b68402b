// The gradient check against services whose true gradients are known.
#include "coordinator/gradcheck/gradient_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "coordinator/gradcheck/difference_ladder.h"
#include "coordinator/gradcheck/gradient_check_report.h"

namespace knap {
namespace gradient_check_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// L = sin(3x + v) + x y², with x, y in [0, 2] × [−1, 1]: curved, so that large steps show their truncation error.
class CurvedService final : public RolloutService {
 public:
  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    std::vector<RolloutOutcome> outcomes;
    for (const RolloutQuery& query : queries) {
      const double x = query.theta[0], y = query.theta[1], v = query.variation[0];
      for (int i = 0; i < 2; ++i) {
        EXPECT_GE(query.theta[i], i == 0 ? 0.0 : -1.0);
        EXPECT_LE(query.theta[i], i == 0 ? 2.0 : 1.0);
      }
      RolloutOutcome outcome{.loss = std::sin(3.0 * x + v) + x * y * y,
                             .gradient = {},
                             .certificate = {.finite = true, .converged = true, .gradient_reliable = true}};
      if (query.gradient) outcome.gradient = {3.0 * std::cos(3.0 * x + v) + y * y, 2.0 * x * y};
      if (spoil) spoil(query, outcome);
      outcomes.push_back(std::move(outcome));
    }
    calls += 1;
    return outcomes;
  }

  std::function<void(const RolloutQuery&, RolloutOutcome&)> spoil;
  int calls = 0;
};

Problem MakeProblem() { return {{{"x", "y"}, {0.0, -1.0}, {2.0, 1.0}, {1.0, 0.0}}, {{{"v"}, UniformDraw{-1.0, 1.0}}}}; }

// theta of draw `index`, as the check draws it.
std::vector<double> FindTheta(const GradientCheckReport& report, std::size_t index) {
  return report.rollouts.at(index).theta;
}

class GradientCheck : public testing::Test {
 protected:
  GradientCheckReport Check() { return CheckGradients(problem_, options_, service_, {}); }

  const Problem problem_ = MakeProblem();
  GradientCheckOptions options_{.rollouts = 20, .seed = 3};
  CurvedService service_;
};

TEST_F(GradientCheck, WhatIsFixedStaysAndIsNotCompared) {
  Problem problem = problem_;
  problem.parameters.fixed = {false, true};
  problem.parameters.initial[1] = 0.25;
  service_.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    EXPECT_EQ(query.theta[1], 0.25);
    if (query.gradient) outcome.gradient[1] = 1e6;  // wrong, and no scale for the other
  };
  const GradientCheckReport report = CheckGradients(problem, options_, service_, {});
  EXPECT_EQ(report.agreed, 20);
  EXPECT_EQ(report.evaluated, CalcLeastRollouts(problem, options_));
  EXPECT_TRUE(report.rollouts[0].parameters[1].fixed);
  EXPECT_GT(report.rollouts[0].parameters[0].plateau_steps, 0);
  EXPECT_EQ(MakeGradientCheckJson(report, problem, options_)["rollouts"][0]["parameters"].size(), 1u);
  // The other one's errors are still found.
  service_.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient) outcome.gradient[0] *= 1.001;
  };
  EXPECT_EQ(CheckGradients(problem, options_, service_, {}).disagreed, 20);
}

TEST_F(GradientCheck, ExactGradientsPass) {
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.checked(), 20);
  EXPECT_EQ(report.agreed, 20);
  EXPECT_EQ(report.draws, 20);
  EXPECT_THAT(ListFailures(report, options_), IsEmpty());
  // The first window decides: truncation of at most h²·L'''/6 = 2e-10 with h = 10^-5.5 of a range of 2 and L''' = 27,
  // and rounding of about 2e-16·L/h = 1e-10 with h = 10^-6.5. Both relative to gradients that may be as small as 0.1.
  EXPECT_GT(report.max_rel_error, 0.0);
  EXPECT_LT(report.max_rel_error, 1e-8);
  EXPECT_EQ(report.evaluated, 20 + 20 * 2 * 3 * 2);
  EXPECT_LE(service_.calls, 2) << "all workers busy: one call a round";
  for (const CheckedRollout& rollout : report.rollouts) {
    for (const ParameterCheck& parameter : rollout.parameters) {
      EXPECT_GE(parameter.plateau_steps, 3);
      EXPECT_NEAR(parameter.difference, parameter.analytic, 1e-6);
    }
  }
}

// Verdicts come while others are still open: those of the first window before the one that needs the whole ladder.
TEST_F(GradientCheck, TellsEachVerdictAsItComes) {
  const std::vector<double> theta = FindTheta(Check(), 0);
  std::vector<std::string> told;
  int calls_at_last_but_one = 0;
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient && query.theta == theta) outcome.gradient[1] += 1.0;
  };
  service_.calls = 0;
  const GradientCheckReport report =
      CheckGradients(problem_, options_, service_, {.on_round = {}, .on_verdict = [&](const CheckedRollout& rollout) {
                                                      told.push_back(FormatVerdict(rollout));
                                                      if (told.size() == 19) calls_at_last_but_one = service_.calls;
                                                    }});
  ASSERT_EQ(told.size(), 20u);
  EXPECT_THAT(told.front(), HasSubstr("draw 1: agreed, relative error "));
  EXPECT_THAT(told.back(), HasSubstr("draw 0: disagreed, relative error "));
  EXPECT_LT(calls_at_last_but_one, service_.calls);
  EXPECT_EQ(report.disagreed, 1);
}

// A hundred rollouts are many rounds, and those of the first are told before the last one is asked.
TEST_F(GradientCheck, TellsVerdictsBeforeAllIsAsked) {
  options_.rollouts = 100;
  std::vector<int> calls;  // when each verdict was told
  CheckGradients(problem_, options_, service_,
                 {.on_round = {}, .on_verdict = [&](const CheckedRollout&) { calls.push_back(service_.calls); }});
  ASSERT_EQ(calls.size(), 100u);
  EXPECT_EQ(calls.front(), 2);  // the draws, and the first round of differences
  EXPECT_GE(calls.back(), 5);   // 1,200 differences
}

TEST_F(GradientCheck, IsReproducible) {
  const GradientCheckReport first = Check(), second = Check();
  EXPECT_EQ(MakeGradientCheckJson(first, problem_, options_), MakeGradientCheckJson(second, problem_, options_));
  options_.seed = 4;
  EXPECT_NE(FindTheta(Check(), 0), FindTheta(first, 0));
}

TEST_F(GradientCheck, AnErrorOfOneInTenThousandIsCaught) {
  service_.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient) outcome.gradient[0] *= 1.0 + 1e-4;
  };
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.agreed + report.disagreed, 20);
  EXPECT_GE(report.disagreed, 15) << "all but those where x hardly counts";
  EXPECT_THAT(ListFailures(report, options_), ElementsAre(HasSubstr("disagree"), HasSubstr("at least 95%")));
  // Every step of the ladder was tried.
  EXPECT_EQ(report.evaluated, 20 + 20 * 2 * 3 * 2 + report.disagreed * 2 * (kLadderSteps - 3));
}

TEST_F(GradientCheck, AnErrorInOneOfTwentyRolloutsFails) {
  const std::vector<double> theta = FindTheta(Check(), 7);
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient && query.theta == theta) outcome.gradient[1] += 1e-3;
  };
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.agreed, 19);
  EXPECT_EQ(report.rollouts[7].verdict, GradientVerdict::kDisagreed);
  EXPECT_EQ(report.rollouts[7].parameters[1].plateau_steps, 0);
  EXPECT_GE(report.rollouts[7].parameters[0].plateau_steps, 3);
  EXPECT_THAT(ListFailures(report, options_), ElementsAre(HasSubstr("1 of 20 rollouts disagree")));
}

// L jumps in slope beside theta. Nearer than three steps of the ladder, no plateau is left: larger steps see the mean
// of both slopes. Further away the gradient holds in a neighbourhood, and the smaller steps say so.
TEST_F(GradientCheck, AKinkBetweenTheStepsIsCaught) {
  const std::vector<double> theta = FindTheta(Check(), 4);
  double distance = 0.0;  // as a fraction of the range
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    const double beyond = query.theta[0] - (theta[0] + 2.0 * distance);
    if (std::abs(query.theta[0] - theta[0]) < 0.01) outcome.loss += 0.5 * std::max(0.0, beyond);
  };
  for (const double exponent : {-20.0, -9.2, -8.6}) {
    distance = std::pow(10.0, exponent);
    const GradientCheckReport report = Check();
    EXPECT_EQ(report.rollouts[4].verdict, GradientVerdict::kDisagreed) << exponent;
    EXPECT_GT(report.rollouts[4].relative_error, 1e-3) << exponent;
    EXPECT_EQ(report.disagreed, 1) << exponent;
  }
  distance = std::pow(10.0, -6.2);
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.disagreed, 0);
  EXPECT_LT(report.rollouts[4].parameters[0].step, distance);
}

TEST_F(GradientCheck, ZeroGradientsDoNotCount) {
  service_.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.variation[0] > 0.0) {
      outcome.loss = 1.0;
      outcome.gradient.assign(outcome.gradient.size(), 0.0);
    }
  };
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.agreed, 20);
  EXPECT_GT(report.zero_gradient, 5);
  EXPECT_EQ(report.draws, 20 + report.zero_gradient);
  for (const CheckedRollout& rollout : report.rollouts) EXPECT_LE(rollout.variation[0], 0.0);
}

TEST_F(GradientCheck, NothingButZeroGradientsFails) {
  service_.spoil = [](const RolloutQuery&, RolloutOutcome& outcome) {
    outcome.gradient.assign(outcome.gradient.size(), 0.0);
  };
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.checked(), 0);
  EXPECT_EQ(report.draws, 20 * kDrawsPerRollout);
  EXPECT_THAT(ListFailures(report, options_), ElementsAre(HasSubstr("only 0 of 20")));
}

// A certificate that warns excuses a gradient that does not agree, and takes nothing from one that does.
TEST_F(GradientCheck, FlaggedIsWhatDoesNotAgreeAndWarns) {
  const GradientCheckReport clean = Check();
  EXPECT_EQ(clean.doubted, 0);
  const auto is = [&](const RolloutQuery& query, std::size_t i) { return query.theta == FindTheta(clean, i); };
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (!query.gradient || !(is(query, 2) || is(query, 7))) return;
    outcome.certificate.gradient_reliable = false;
    if (is(query, 2)) outcome.gradient[0] += 1.0;
  };
  GradientCheckReport report = Check();
  EXPECT_EQ(report.rollouts[2].verdict, GradientVerdict::kFlagged);
  EXPECT_EQ(report.rollouts[7].verdict, GradientVerdict::kAgreed);
  EXPECT_LT(report.rollouts[7].relative_error, 1e-6);
  EXPECT_EQ(report.flagged, 1);
  EXPECT_EQ(report.agreed, 19);
  EXPECT_EQ(report.doubted, 2);
  EXPECT_THAT(ListFailures(report, options_), IsEmpty()) << "5% may be flagged";

  // One that does not converge has no gradient; together they are too many.
  service_.spoil = [&, smooth = service_.spoil](const RolloutQuery& query, RolloutOutcome& outcome) {
    smooth(query, outcome);
    if (!is(query, 5)) return;
    outcome.certificate.converged = false;
    outcome.loss = std::numeric_limits<double>::quiet_NaN();
    outcome.gradient.clear();
  };
  report = Check();
  EXPECT_EQ(report.flagged, 2);
  EXPECT_EQ(report.doubted, 3);
  EXPECT_EQ(report.nonconverged, 1);
  EXPECT_EQ(report.disagreed, 0);
  EXPECT_THAT(ListFailures(report, options_),
              ElementsAre(HasSubstr("2 of 20 rollouts are flagged"), HasSubstr("18 of 20 rollouts agree")));
  options_.flagged = 0.1;
  EXPECT_THAT(ListFailures(report, options_), IsEmpty()) << "10% may be flagged";
}

// The rollouts that are subtracted take the steps of the one that they are compared with.
TEST_F(GradientCheck, DifferencesFollowTheStepsOfTheirRollout) {
  int differences = 0;
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome&) {
    if (query.gradient) {
      EXPECT_TRUE(query.theta_nodes.empty());
      return;
    }
    ++differences;
    ASSERT_EQ(query.theta_nodes.size(), 2u);
    const double off =
        std::abs(query.theta[0] - query.theta_nodes[0]) + std::abs(query.theta[1] - query.theta_nodes[1]);
    EXPECT_GT(off, 0.0);
    EXPECT_LT(off, 1e-2);
  };
  Check();
  EXPECT_GE(differences, 20 * 2 * 3 * 2);
}

TEST_F(GradientCheck, ANumberThatIsNoneWithoutAWarningIsADisagreement) {
  const std::vector<double> theta = FindTheta(Check(), 0);
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient && query.theta == theta) outcome.gradient[1] = std::numeric_limits<double>::infinity();
  };
  EXPECT_EQ(Check().rollouts[0].verdict, GradientVerdict::kDisagreed);
}

// Difference rollouts that fail leave gaps in the ladder; a plateau is found beside them.
TEST_F(GradientCheck, FailedDifferencesDoNotAgree) {
  service_.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (!query.gradient) outcome.certificate.converged = false;
  };
  const GradientCheckReport report = Check();
  EXPECT_EQ(report.disagreed, 20);
  const nlohmann::ordered_json json = MakeGradientCheckJson(report, problem_, options_);
  EXPECT_TRUE(json["rollouts"][0]["parameters"][0]["difference"].is_null());
}

TEST_F(GradientCheck, JsonHasARowForEachParameter) {
  const nlohmann::ordered_json json = MakeGradientCheckJson(Check(), problem_, options_);
  EXPECT_EQ(json["checked"], 20);
  EXPECT_EQ(json["quarantined"], 0);
  EXPECT_EQ(json["passed"], true);
  EXPECT_GT(json["max_rel_error"], 0.0);
  ASSERT_EQ(json["rollouts"].size(), 20u);
  EXPECT_EQ(json["rollouts"][3]["parameters"][1]["name"], "y");
  EXPECT_EQ(json["rollouts"][3]["verdict"], "agreed");
}

TEST_F(GradientCheck, TextTellsHowToRepeatTheWorst) {
  const std::vector<double> theta = FindTheta(Check(), 7);
  service_.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.gradient && query.theta == theta) outcome.gradient[1] += 1e-3;
  };
  const std::string text = FormatGradientCheck(Check(), problem_, options_, "knap rollout c.yaml");
  EXPECT_THAT(text, HasSubstr("draw 7: disagreed; worst y: "));
  EXPECT_THAT(text, HasSubstr("knap rollout c.yaml --theta="));
  EXPECT_THAT(text, HasSubstr("failed: 1 of 20 rollouts disagree"));
}

TEST_F(GradientCheck, RefusesOptionsOutOfRange) {
  options_.rollouts = 0;
  EXPECT_THROW(Check(), std::invalid_argument);
  options_ = {.rollouts = 1, .tolerance = 0.0};
  EXPECT_THROW(Check(), std::invalid_argument);
  options_ = {.rollouts = 1, .flagged = 1.01};
  EXPECT_THROW(Check(), std::invalid_argument);
}

// Truncation h² L'''/6 and rounding noise/h leave less than three steps between them; without truncation there is room.
TEST(DifferenceLadder, AsksFourthOrderWhereSecondLeavesNoRoom) {
  const auto find = [](double fourth) {
    DifferenceLadder ladder;
    for (std::vector<int> next = ladder.ListNextSteps(); !next.empty(); next = ladder.ListNextSteps()) {
      for (const int k : next) {
        const double h = CalcLadderStep(k);
        const double noise = (k % 2 == 0 ? 1.0 : -1.0) * 5e-13 / h;
        ladder.Set(k, 1.0 + fourth + 1e9 * h * h + noise);
      }
    }
    return ladder.FindBestWindow(1.0, 1e-5);
  };
  EXPECT_GE(find(0.0).plateau_steps, 3);
  EXPECT_NEAR(find(0.0).difference, 1.0, 1e-5);
  EXPECT_EQ(find(3e-5).plateau_steps, 0);  // and a wrong derivative has none of either order
}

TEST(DifferenceLadder, FindsTheWindowWithTheLeastError) {
  DifferenceLadder ladder;
  EXPECT_THAT(ladder.ListNextSteps(), ElementsAre(9, 10, 11));
  for (const int k : {9, 10, 11}) ladder.Set(k, 1.0 + std::pow(0.1, k - 4));
  EXPECT_THAT(ladder.ListNextSteps(), ElementsAre(8, 12));
  EXPECT_EQ(ladder.FindBestWindow(1.0, 2e-6).plateau_steps, 0) << "two steps agree; three are needed";
  ladder.Set(8, 2.0);
  ladder.Set(12, 1.0);
  const DifferenceLadder::Window window = ladder.FindBestWindow(1.0, 2e-6);
  EXPECT_EQ(window.middle, 11);
  EXPECT_NEAR(window.error, 1e-6, 1e-14);
  EXPECT_EQ(window.plateau_steps, 3);
  EXPECT_EQ(ladder.FindBestWindow(1.0, 2e-5).plateau_steps, 4);
}

}  // namespace gradient_check_test
}  // namespace knap
