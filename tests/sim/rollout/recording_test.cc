// What a recording holds, against the rollout that it is of and against statics.
#include "sim/rollout/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace recording_test {

using Eigen::Vector3d;

RolloutModel Load(const std::string& name, const std::vector<std::string>& overrides = {}) {
  const LoadedScenario scenario = LoadScenario(std::string(KNAP_CONFIGS "/") + name, overrides);
  EXPECT_EQ(scenario.parsed.FormatErrors(), "");
  return RolloutModel(scenario.files);
}

RolloutInput MakeInput(const RolloutModel& model, const std::vector<double>& variation) {
  RolloutInput input;
  input.theta = model.initial_theta();
  input.variation = variation;
  input.controls = Eigen::VectorXd::Zero(model.num_controls());
  input.want_gradient = false;
  return input;
}

TEST(RecordingTest, IsOfTheSameRollout) {
  RolloutModel model = Load("pushing.yaml");
  const RolloutInput input = MakeInput(model, {0.005, 0.1});
  const RolloutOutput run = model.Run(input, {});
  const RecordedRollout recorded = model.Record(input, 0.0);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(recorded.output.loss), std::bit_cast<std::uint64_t>(run.loss));
  EXPECT_EQ(recorded.output.success, run.success);
  const Recording& seen = recorded.recording;
  ASSERT_EQ(seen.time.size(), static_cast<std::size_t>(run.steps) + 1);
  // What the loss sees of the pea at each state.
  const double step = model.scene().rollout.step;
  for (std::size_t k = 0; k < seen.time.size(); ++k) ASSERT_NEAR(seen.time[k], step * static_cast<double>(k), 1e-12);
  RolloutModel sum = Load("pushing.yaml", {"loss.task=[{signals: [pea_x, pea_y], when: {type: samples, every: " +
                                           std::to_string(step) + " s}, shape: absolute}]"});
  ASSERT_EQ(seen.signals.size(), 2U);
  EXPECT_EQ(seen.signals[1].name, "pea_y");
  EXPECT_EQ(seen.signals[1].unit, "m");
  ASSERT_EQ(seen.signals[1].values.size(), seen.time.size());
  double expected = 0.0;
  for (std::size_t k = 1; k < seen.time.size(); ++k) {
    const Vector3d& p_W = seen.Find("pea").X_WB[k].p;
    expected += std::abs(p_W.x()) + std::abs(p_W.y());
    ASSERT_EQ(seen.signals[1].values[k], p_W.y());
  }
  EXPECT_EQ(sum.Run(input, {}).loss, expected);
  EXPECT_TRUE(seen.Find("pea").moves);
  EXPECT_TRUE(seen.Find("pusher").moves);
  EXPECT_FALSE(seen.Find("table").moves);
}

// A pea at rest is borne by its weight, from below its centre.
TEST(RecordingTest, ForcesAreThoseOfTheContacts) {
  RolloutModel model = Load("pushing.yaml");
  const Recording seen = model.Record(MakeInput(model, {0.005, 0.1}), 0.0).recording;
  const auto find = [&](const std::string& a, const std::string& b) -> const Recording::Contact& {
    for (const Recording::Contact& contact : seen.contacts) {
      if (contact.bodies == std::array<std::string, 2>{a, b}) return contact;
    }
    throw std::runtime_error("no such contact");
  };
  const Recording::Contact& table = find("pea", "table");
  const Recording::Contact& pusher = find("pea", "pusher");
  double mass = 0.0;
  for (const Body& body : model.scene().bodies) {
    if (body.name == "pea") mass = std::get<SolidInertia>(*body.inertia).mass;
  }
  std::size_t k = 20;  // settled, and not yet pushed
  ASSERT_TRUE(std::isnan(pusher.p_W[k].x()));
  EXPECT_EQ(pusher.f_W[k], Vector3d::Zero());
  EXPECT_NEAR(table.f_W[k].z(), 9.81 * mass, 1e-4 * 9.81 * mass);
  const Vector3d& pea = seen.Find("pea").X_WB[k].p;
  EXPECT_NEAR(table.p_W[k].x(), pea.x(), 1e-6);
  EXPECT_NEAR(table.p_W[k].y(), pea.y(), 1e-6);
  EXPECT_NEAR(table.p_W[k].z(), 0.0, 1e-4);
  EXPECT_GT(table.depth[k], 0.0);
  // The pusher comes from below in y and pushes the pea ahead.
  while (k < seen.time.size() && std::isnan(pusher.p_W[k].x())) ++k;
  ASSERT_LT(k, seen.time.size()) << "never pushed";
  EXPECT_GT(pusher.f_W[k].y(), 0.0);
  EXPECT_LT((pusher.p_W[k] - seen.Find("pea").X_WB[k].p).norm(), 0.008) << "on the pea";
}

TEST(RecordingTest, APeriodThinsOutWithoutChangingAnything) {
  RolloutModel model = Load("winding.yaml", {"rollout.horizon=0.2 s", "loss.task[0].when.until=0.2 s",
                                             "loss.distillation[0].when.until=0.2 s", "success.of[1].when.from=0.1 s"});
  std::vector<double> variation;
  for (std::size_t i = 0; i < model.scene().variation.size(); ++i) variation.push_back(0.1);
  const RolloutInput input = MakeInput(model, variation);
  const Recording all = model.Record(input, 0.0).recording;
  const Recording thin = model.Record(input, 0.02).recording;
  EXPECT_EQ(thin.time.front(), 0.0);
  EXPECT_LE(thin.time.size(), 12U);
  EXPECT_GE(thin.time.size(), 10U);
  const std::string last = "rope link 14";
  std::size_t k = 0;
  for (std::size_t i = 0; i < thin.time.size(); ++i) {
    while (all.time[k] < thin.time[i]) ++k;
    ASSERT_EQ(all.time[k], thin.time[i]);
    EXPECT_EQ(all.Find(last).X_WB[k].p, thin.Find(last).X_WB[i].p);
    EXPECT_LE(thin.time[i] - 0.02 * static_cast<double>(i), 0.02) << "the first step at or after each multiple";
  }
}

// The angle between a link and what carries it moves by what the joint's coordinate moves by.
TEST(RecordingTest, JointsTurnWhatTheyCarry) {
  RolloutModel model = Load("reaching.yaml");
  RolloutInput input = MakeInput(model, {});
  input.controls.setConstant(0.4);
  const Recording seen = model.Record(input, 0.0).recording;
  ASSERT_FALSE(seen.joints.empty());
  for (const Recording::Joint& joint : seen.joints) {
    std::string parent;
    for (const Body& body : model.scene().bodies) {
      if (body.name == joint.body) parent = body.parent;
    }
    const auto turn = [&](std::size_t k) {
      const Eigen::Matrix3d R_WB = seen.Find(joint.body).X_WB[k].R;
      return parent == kWorldName ? R_WB : Eigen::Matrix3d(seen.Find(parent).X_WB[k].R.transpose() * R_WB);
    };
    ASSERT_EQ(joint.unit, "rad");
    double moved = 0.0;
    for (std::size_t k = 1; k < seen.time.size(); ++k) {
      const double angle = Eigen::AngleAxisd(turn(k - 1).transpose() * turn(k)).angle();
      EXPECT_NEAR(angle, std::abs(joint.q[k] - joint.q[k - 1]), 1e-7) << joint.body << " at " << seen.time[k];
      moved += angle;
    }
    EXPECT_GT(moved, 0.01) << joint.body << " hardly moves: nothing was tested";
  }
}

}  // namespace recording_test
}  // namespace knap
