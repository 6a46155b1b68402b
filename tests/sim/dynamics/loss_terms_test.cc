// Losses on paths written down by hand: the crossing of a ballistic path against its closed form, and cotangents
// against differences on both sides of every case of the loss.
#include "sim/rollout/loss_terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr int kBody = 3;

// p = p0 + v0 t + a t²/2 at the multiples of `step`, one state a step.
BodyPath MakeBallisticPath(const Vector3d& p0, const Vector3d& v0, const Vector3d& a, double step, int steps) {
  BodyPath path;
  path.body = kBody;
  for (int k = 0; k <= steps; ++k) {
    const double t = k * step;
    path.time.push_back(t);
    path.p_W.push_back(p0 + t * v0 + 0.5 * t * t * a);
    path.v_W.push_back(v0 + t * a);
    path.state_of_step.push_back(k);
  }
  return path;
}

CrossingLoss MakeLoss() {
  CrossingLoss loss;
  loss.opening = {"pea", Axis::kY, 0.37, Axis::kX, 0.004, 0.02};
  loss.weight = 2.0;
  loss.length_unit = 0.1;
  loss.shortfall_weight = 3.0;
  loss.shortfall_scale = 0.05;
  return loss;
}

// A cubic through position and velocity is exact on a ballistic path, whatever the step.
TEST(Crossing, OfABallisticPathIsExact) {
  const CrossingLoss loss = MakeLoss();
  const Vector3d p0(0.01, 0.1, 0.3);
  const Vector3d v0(0.05, 0.4, 0.2);
  const Vector3d a(-0.11, 0.3, -9.81);
  // 0.1 + 0.4 t + 0.15 t² = 0.37
  const double time = (-0.4 + std::sqrt(0.16 + 4.0 * 0.15 * 0.27)) / 0.3;
  const double x = 0.01 + 0.05 * time - 0.055 * time * time;
  for (const double step : {0.4, 0.1, 1e-3}) {
    const BodyPath path = MakeBallisticPath(p0, v0, a, step, static_cast<int>(std::lround(0.8 / step)));
    const auto crossing = FindCrossing(path, loss.opening);
    ASSERT_TRUE(crossing);
    EXPECT_NEAR(crossing->time, time, 1e-14);
    EXPECT_NEAR(crossing->x, x, 1e-15);
    EXPECT_TRUE(CrossesInside(loss.opening, path));
    EXPECT_EQ(EvaluateCrossingLoss(loss, path, nullptr), 0.0);
  }
  // The first of two passages counts: thrown up through the plane and back.
  CrossingLoss high = loss;
  high.opening = {"pea", Axis::kZ, 0.301, Axis::kX, 0.0, 0.02};
  const double up = (0.2 - std::sqrt(0.04 - 2.0 * 9.81 * 0.001)) / 9.81;
  const auto crossing = FindCrossing(MakeBallisticPath(p0, v0, a, 1e-3, 800), high.opening);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(crossing->time, up, 1e-14);
}

TEST(Crossing, LossCountsTheDistanceBeyondTheOpening) {
  const CrossingLoss loss = MakeLoss();
  for (const double x : {-0.05, -0.017, -0.015, 0.0, 0.023, 0.025, 0.06}) {
    const BodyPath path = MakeBallisticPath(Vector3d(x, 0.1, 0), Vector3d(0, 0.5, 0), Vector3d::Zero(), 0.1, 10);
    // The opening reaches from −16 to 24 mm; lengths count in units of 100 mm, weight 2.
    const double beyond = x < -0.016 ? -0.016 - x : x > 0.024 ? x - 0.024 : 0.0;
    EXPECT_NEAR(EvaluateCrossingLoss(loss, path, nullptr), 200.0 * beyond * beyond, 1e-15) << x;
    EXPECT_EQ(CrossesInside(loss.opening, path), beyond == 0.0) << x;
  }
}

TEST(Crossing, ShortfallIsQuadraticAtFirstAndLevelsOff) {
  const CrossingLoss loss = MakeLoss();
  const auto evaluate = [&](double missing) {
    return EvaluateCrossingLoss(
        loss, MakeBallisticPath(Vector3d(0, 0.37 - missing - 0.1, 0), Vector3d(0, 1, 0), Vector3d::Zero(), 0.01, 10),
        nullptr);
  };
  EXPECT_NEAR(evaluate(1e-4), 300.0 * 1e-8, 1e-4 * 300.0 * 1e-8);
  EXPECT_NEAR(evaluate(50.0), 300.0 * 0.05 * 0.05, 1e-5);
  double previous = 0.0;
  for (const double missing : {1e-3, 0.01, 0.05, 0.2, 1.0}) {
    EXPECT_GT(evaluate(missing), previous);
    previous = evaluate(missing);
  }
  const BodyPath stopped = MakeBallisticPath(Vector3d(0, 0.1, 0), Vector3d(0, 0.1, 0), Vector3d::Zero(), 0.1, 10);
  EXPECT_FALSE(FindCrossing(stopped, loss.opening));
  EXPECT_FALSE(CrossesInside(loss.opening, stopped));
}

// Sum of cotangents · perturbation against the difference of the loss, for every number of every state.
template <class Evaluate>
double CheckCotangents(const BodyPath& path, const std::vector<StateCotangent>& cotangents, const Evaluate& evaluate) {
  const int count = static_cast<int>(path.p_W.size());
  std::vector<Vector3d> bar_p(count, Vector3d::Zero());
  std::vector<Vector3d> bar_v(count, Vector3d::Zero());
  double largest = 0.0;
  for (const StateCotangent& c : cotangents) {
    EXPECT_EQ(c.body, kBody);
    bar_p.at(c.state) += c.p_W;
    bar_v.at(c.state) += c.v_W;
    largest = std::max({largest, bar_p[c.state].cwiseAbs().maxCoeff()});
  }
  const double step = 1e-6;
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 6; ++i) {
      const auto moved = [&](double s) {
        BodyPath other = path;
        (i < 3 ? other.p_W[k](i) : other.v_W[k](i - 3)) += s;
        return evaluate(other);
      };
      const double expected = (moved(step) - moved(-step)) / (2.0 * step);
      const double actual = i < 3 ? bar_p[k](i) : bar_v[k](i - 3);
      EXPECT_NEAR(actual, expected, 1e-7 * (1.0 + largest)) << "state " << k << " number " << i;
    }
  }
  return largest;
}

enum class Fate { kInside, kLeft, kRight, kShort, kShortAndLeft, kFromBeyond };

class FateTest : public testing::TestWithParam<Fate> {};

TEST_P(FateTest, CotangentsEqualDifferences) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const CrossingLoss loss = MakeLoss();
  for (int trial = 0; trial < 20; ++trial) {
    const Fate fate = GetParam();
    const bool is_short = fate == Fate::kShort || fate == Fate::kShortAndLeft;
    const double speed = (is_short ? 0.2 : 0.5) * (fate == Fate::kFromBeyond ? -1.0 : 1.0);
    const double x = fate == Fate::kLeft || fate == Fate::kShortAndLeft ? -0.06 : fate == Fate::kInside ? 0.0 : 0.05;
    BodyPath path = MakeBallisticPath(Vector3d(x, fate == Fate::kFromBeyond ? 0.6 : 0.1, 0), Vector3d(0, speed, 0),
                                      Vector3d::Zero(), 0.1, 10);
    for (std::size_t k = 0; k < path.p_W.size(); ++k) {
      path.p_W[k] += 5e-3 * Vector3d(u(generator), u(generator), u(generator));
      path.v_W[k] += 5e-2 * Vector3d(u(generator), u(generator), u(generator));
    }
    EXPECT_EQ(FindCrossing(path, loss.opening).has_value(), !is_short);
    std::vector<StateCotangent> cotangents;
    const double value = EvaluateCrossingLoss(loss, path, &cotangents);
    EXPECT_EQ(value, EvaluateCrossingLoss(loss, path, nullptr));
    const double largest = CheckCotangents(
        path, cotangents, [&](const BodyPath& other) { return EvaluateCrossingLoss(loss, other, nullptr); });
    if (fate == Fate::kInside) {
      EXPECT_EQ(value, 0.0);
      EXPECT_TRUE(cotangents.empty());
    } else {
      EXPECT_GT(value, 0.0);
      EXPECT_GT(largest, 0.1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fates, FateTest,
                         testing::Values(Fate::kInside, Fate::kLeft, Fate::kRight, Fate::kShort, Fate::kShortAndLeft,
                                         Fate::kFromBeyond));

PositionMatchLoss MakeMatch(Normalization normalize) {
  PositionMatchLoss loss;
  loss.body = "pea";
  loss.axes = {Axis::kX, Axis::kZ};
  loss.sample_period = 0.02;
  loss.normalize = normalize;
  loss.weight = 0.5;
  loss.length_unit = 0.01;
  return loss;
}

TEST(PositionMatch, DoesNotDependOnTheStep) {
  for (const Normalization normalize : {Normalization::kSum, Normalization::kMean}) {
    const PositionMatchLoss loss = MakeMatch(normalize);
    const auto evaluate = [&](double step, int steps) {
      return EvaluatePositionMatch(
          loss, step, MakeBallisticPath(Vector3d(0, 1, 0), Vector3d(1, 2, 3), Vector3d(0, 0, -9.81), step, steps),
          MakeBallisticPath(Vector3d(0, 0, 0.01), Vector3d(0.9, 2, 3), Vector3d(0, 0, -9.81), step, steps), nullptr);
    };
    // Differences (0.1 t, −0.01) at the 50 samples 0.02 … 1 s, in centimetres: Σ (100·0.01 t² + 1), weight 1/2.
    const double sum = 0.5 * (100.0 * 0.02 * 0.02 * 50.0 * 51.0 * 101.0 / 6.0 + 50.0);
    const double expected = normalize == Normalization::kSum ? sum : sum / 50.0;
    for (const int divisions : {1, 2, 4, 20}) {
      EXPECT_NEAR(evaluate(0.02 / divisions, 50 * divisions), expected, 1e-11 * expected) << divisions;
    }
  }
}

TEST(PositionMatch, CotangentsEqualDifferencesAndSubstepsAreSkipped) {
  const PositionMatchLoss loss = MakeMatch(Normalization::kMean);
  BodyPath path = MakeBallisticPath(Vector3d(0, 0, 0), Vector3d(0.1, 0.2, 0.3), Vector3d(0, 1, -1), 0.01, 8);
  const BodyPath reference = MakeBallisticPath(Vector3d(0, 0, 0.02), Vector3d(0.2, 0, 0), Vector3d(1, 0, 0), 0.01, 8);
  std::vector<StateCotangent> cotangents;
  EvaluatePositionMatch(loss, 0.01, path, reference, &cotangents);
  CheckCotangents(path, cotangents,
                  [&](const BodyPath& other) { return EvaluatePositionMatch(loss, 0.01, other, reference, nullptr); });
  // A cut step puts a state between whole steps; the value does not see it.
  const double whole = EvaluatePositionMatch(loss, 0.01, path, reference, nullptr);
  path.time.insert(path.time.begin() + 3, 0.025);
  path.p_W.insert(path.p_W.begin() + 3, Vector3d(9, 9, 9));
  path.v_W.insert(path.v_W.begin() + 3, Vector3d::Zero());
  for (int n = 3; n <= 8; ++n) ++path.state_of_step[n];
  EXPECT_EQ(EvaluatePositionMatch(loss, 0.01, path, reference, nullptr), whole);
}

}  // namespace
}  // namespace knap
