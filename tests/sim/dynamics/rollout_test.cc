// Whole rollouts from scenario files: a swing against the elliptic integral, the same bits whatever ran before, and
// the same physics in whatever order the bodies are listed.
#include "sim/rollout/rollout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace rollout_test {

using Eigen::VectorXd;
using Files = std::map<std::string, std::string>;

// A rod hung from a post by its own frame, 250 mm from the pivot to its centre of mass, released at 120°.
constexpr char kSwingYaml[] = R"(schema: 2
name: swing
bodies:
  - name: tip
    parent: rod
    joint: {type: fixed, position: [0 mm, 0 mm, -250 mm]}
  - name: rod
    parent: post
    joint: {type: revolute, axis: [0, 2, 0]}
    inertia:
      {type: explicit, mass: 300 g, center: [0 mm, 0 mm, -25 cm], moments: [2e-3 kg*m^2, 2e-3 kg*m^2, 1e-3 kg*m^2]}
    initial: {angle: 120 deg}
  - name: post
    joint: {type: fixed, position: [1 m, 2 m, 3 m], orientation_rpy: [0 deg, 0 deg, 90 deg]}
rollout: {horizon: 3 s, step: 1 ms, integrator: bdf2}
)";

// Of a body's origin, at every step.
struct Path {
  std::vector<double> time;
  std::vector<Eigen::Vector3d> p_W;
};

Path Trace(RolloutModel* model, const RolloutInput& input, const std::string& body) {
  const Recording recording = model->Record(input, 0.0).recording;
  Path path{recording.time, {}};
  for (const Pose& X_WB : recording.Find(body).X_WB) path.p_W.push_back(X_WB.p);
  return path;
}

TEST(Rollout, ASwingFromAFileHasThePeriodOfTheEllipticIntegral) {
  RolloutModel model(Files{{kScenarioFileName, kSwingYaml}});
  const Path path = Trace(&model, {}, "tip");
  // The post turns the swing's plane from x to y of the world.
  EXPECT_NEAR(path.p_W[0].x(), 1.0, 1e-12);
  EXPECT_NEAR(path.p_W[0].y(), 2.0 - 0.25 * std::sin(2.0 * std::acos(-1.0) / 3.0), 1e-12);
  EXPECT_NEAR(path.p_W[0].z(), 3.125, 1e-12);
  std::vector<double> passages;
  for (std::size_t k = 1; k < path.p_W.size(); ++k) {
    const double before = path.p_W[k - 1].y() - 2.0;
    const double after = path.p_W[k].y() - 2.0;
    // The tip is above the pivot at first, so only passages below it count.
    if (before * after < 0.0) passages.push_back(path.time[k - 1] + before / (before - after) * 1e-3);
  }
  ASSERT_GE(passages.size(), 3u);
  const double omega = std::sqrt(0.3 * 9.81 * 0.25 / (2e-3 + 0.3 * 0.25 * 0.25));
  const double period = 4.0 / omega * std::comp_ellint_1(std::sin(std::acos(-1.0) / 3.0));
  // BDF2 at ω h = 0.006: some (ω h)² = 4e-5.
  EXPECT_NEAR((passages[2] - passages[0]) / period, 1.0, 1e-4);
}

LoadedScenario LoadPushing() {
  const std::vector<std::string> overrides{"rollout.horizon=2.4 s"};  // past the first contact with the pusher
  return LoadScenario(std::string(KNAP_CONFIGS) + "/pushing.yaml", overrides);
}

bool SameBits(const RolloutOutput& a, const RolloutOutput& b) {
  return a.loss == b.loss && a.success == b.success && a.gradient == b.gradient && a.steps == b.steps &&
         a.certificate.worst_residual == b.certificate.worst_residual &&
         a.certificate.newton_iterations == b.certificate.newton_iterations &&
         a.certificate.contact_onsets == b.certificate.contact_onsets;
}

TEST(Rollout, GivesTheSameBitsWhateverRanBefore) {
  const LoadedScenario scenario = LoadPushing();
  ASSERT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
  RolloutModel model(scenario.files);
  const VectorXd theta = model.initial_theta();
  VectorXd other = theta;
  other(0) += 2e-3;
  other(3) += 5e-3;
  const RolloutInput task{theta, {}, {0.007, 0.095}, true};
  const RolloutInput distilled{other, theta, {0.007, 0.095}, true};
  const RolloutOutput first = model.Run(task, {});
  EXPECT_TRUE(first.certificate.converged);
  EXPECT_GE(first.certificate.contact_onsets, 1);
  EXPECT_GT(first.gradient.norm(), 0.0);
  EXPECT_TRUE(SameBits(first, model.Run(task, {})));
  const RolloutOutput first_distilled = model.Run(distilled, {});
  EXPECT_GT(first_distilled.loss, 0.0);
  EXPECT_FALSE(SameBits(first, first_distilled));
  // Others in between: more designs and references than a small cache holds.
  for (int i = 0; i < 6; ++i) {
    VectorXd elsewhere = theta;
    elsewhere(i) += 1e-3 * (i + 1);
    model.Run({elsewhere, i % 2 == 0 ? VectorXd() : other, {-0.01 + 0.004 * i, 0.085 + 0.005 * i}, i % 3 == 0}, {});
  }
  EXPECT_TRUE(SameBits(first, model.Run(task, {})));
  EXPECT_TRUE(SameBits(first_distilled, model.Run(distilled, {})));
  RolloutModel fresh(scenario.files);
  EXPECT_TRUE(SameBits(first_distilled, fresh.Run(distilled, {})));
  EXPECT_TRUE(SameBits(first, fresh.Run(task, {})));
  // Without the gradient the loss is the same.
  EXPECT_EQ(fresh.Run({theta, {}, {0.007, 0.095}, false}, {}).loss, first.loss);
}

TEST(Rollout, DistillationAgainstItselfIsZero) {
  const LoadedScenario scenario = LoadPushing();
  RolloutModel model(scenario.files);
  const VectorXd theta = model.initial_theta();
  const RolloutOutput out = model.Run({theta, theta, {0.007, 0.095}, true}, {});
  EXPECT_EQ(out.loss, 0.0);
  EXPECT_EQ(out.gradient.norm(), 0.0);
}

void ExpectSamePath(const Path& a, const Path& b) {
  ASSERT_EQ(a.p_W.size(), b.p_W.size());
  EXPECT_GT((a.p_W.back() - a.p_W.front()).norm(), 1e-3);
  for (std::size_t k = 0; k < a.p_W.size(); ++k) ASSERT_EQ(a.p_W[k], b.p_W[k]) << k;
}

TEST(Rollout, TheOrderOfBodiesDoesNotMatter) {
  LoadedScenario scenario = LoadPushing();
  RolloutModel model(scenario.files);
  const VectorXd theta = model.initial_theta();
  Scene reordered = scenario.parsed.scene;
  std::reverse(reordered.bodies.begin(), reordered.bodies.end());
  scenario.files[kScenarioFileName] = DumpScene(reordered);
  RolloutModel reversed(scenario.files);
  EXPECT_NE(model.scene().bodies.front().name, reversed.scene().bodies.front().name);
  ExpectSamePath(Trace(&model, {theta, {}, {0.007, 0.095}}, "pea"),
                 Trace(&reversed, {theta, {}, {0.007, 0.095}}, "pea"));
  EXPECT_TRUE(
      SameBits(model.Run({theta, {}, {0.007, 0.095}, true}, {}), reversed.Run({theta, {}, {0.007, 0.095}, true}, {})));
}

TEST(Rollout, AChildMayBeListedBeforeItsParent) {
  const std::string text = kPendulumYaml;
  Scene scene = ParseScenarioFiles({{kScenarioFileName, text}});
  // The lower body hangs at an offset, so that it has a path of its own.
  scene.bodies[1].joint.position = Eigen::Vector3d(0, 0, -0.3);
  RolloutModel model(Files{{kScenarioFileName, DumpScene(scene)}});
  std::swap(scene.bodies[0], scene.bodies[1]);
  RolloutModel swapped(Files{{kScenarioFileName, DumpScene(scene)}});
  EXPECT_EQ(swapped.scene().bodies[0].name, "lower");
  ExpectSamePath(Trace(&model, {}, "lower"), Trace(&swapped, {}, "lower"));
}

}  // namespace rollout_test
}  // namespace knap
