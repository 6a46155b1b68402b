// configs/flipping.yaml and flipping_one.yaml: what DiffHand computes where nothing is done, and the box by itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "sim/rollout/check_model.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace flipping_test {

using Eigen::VectorXd;
using std::numbers::pi;

constexpr double kGravity = 9.8, kSide = 0.06, kMass = 0.216;  // of the box

std::map<std::string, std::string> LoadFiles(const std::string& config, const std::vector<std::string>& overrides) {
  LoadedScenario scenario = LoadScenario(KNAP_CONFIGS "/" + config, overrides);
  CheckModel(scenario);
  EXPECT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
  return scenario.files;
}

const std::vector<double>& FindSignal(const Recording& recording, const std::string& name) {
  for (const Recording::Signal& signal : recording.signals) {
    if (signal.name == name) return signal.values;
  }
  ADD_FAILURE() << name;
  return recording.time;
}

RolloutInput MakeInput(const RolloutModel& model, const VectorXd& controls) {
  RolloutInput input;
  input.theta = model.design() ? model.initial_theta() : VectorXd();
  input.controls = controls;
  input.want_gradient = false;
  return input;
}

// ---- DiffHand -------------------------------------------------------------------------------------------------------

// A solid box of 1 g/cm³ as DiffHand makes one of a cage: the mean section times the length; g, cm.
struct CageMass {
  double center, mass, xx, yy, zz;
};
CageMass MakeCageMass(double center, double width, double height, double length) {
  const double m = width * height * length;
  return {center, m, m / 12 * (width * width + height * height), m / 12 * (height * height + length * length),
          m / 12 * (width * width + length * length)};
}

std::string MakeInertia(const std::string& body, const std::vector<CageMass>& parts) {
  double m = 0.0, mx = 0.0, xx = 0.0, yy = 0.0, zz = 0.0;
  for (const CageMass& part : parts) {
    m += part.mass;
    mx += part.mass * part.center;
  }
  const double center = mx / m;
  for (const CageMass& part : parts) {
    const double shift = part.mass * (part.center - center) * (part.center - center);
    xx += part.xx;
    yy += part.yy + shift;
    zz += part.zz + shift;
  }
  return fmt::format(
      "bodies.{}.inertia={{type: explicit, mass: {} g, center: [{} cm, 0 cm, 0 cm], moments: [{} g*cm^2, {} g*cm^2, {} "
      "g*cm^2]}}",
      body, m, center, xx, yy, zz);
}

// Of links and floor. Every joint's cage counts twice, with what carries it and with what it carries; centres lie in
// the links' frames.
std::vector<std::string> MakeDiffHandConstants() {
  const auto palm = [](double center) { return MakeCageMass(center, 1.6, 3.24, 0.7); };
  const auto knuckle = [](double center) { return MakeCageMass(center, 2.1, 2.92, 2.75); };
  const auto joint = [](double center) { return MakeCageMass(center, 2.6, 2.6, 2.06); };
  const auto phalanx = [](double center) { return MakeCageMass(center, 2.6, 2.6, 2.34); };
  std::vector<std::string> constants = {
      MakeInertia("palm", {palm(0.35), knuckle(0.7 + 1.375)}),
      MakeInertia("knuckle", {knuckle(1.375 - 1.15), joint(1.6 + 1.03)}), MakeInertia("phalanx_2", {phalanx(1.17)}),
      MakeInertia("tip", {MakeCageMass(1.105, 2.6, 2.6, 2.21)}), "bodies.carriage.inertia.mass=0.001 g",
      // Springs of 5,000 N/m at the corners hold a turn as this does.
      "contacts[18].stiffness=8e6 N/m^3"};
  for (const int i : {0, 1, 2}) {
    constants.push_back(MakeInertia(fmt::format("joint_{}", i), {joint(1.03 - 1.08)}));
    if (i < 2) constants.push_back(MakeInertia(fmt::format("phalanx_{}", i), {phalanx(1.17), joint(2.34 + 1.03)}));
  }
  return constants;
}

// The meshes with sections of `share` of their size, in the same cages.
void ShrinkSections(double share, std::map<std::string, std::string>* files) {
  for (auto& [name, text] : *files) {
    if (!name.ends_with(".obj") || name.ends_with("_cage.obj")) continue;
    std::istringstream lines(text);
    std::string shrunk;
    for (std::string line; std::getline(lines, line);) {
      double x = 0.0, y = 0.0, z = 0.0;
      if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) {
        line = fmt::format("v {} {} {}", x, share * y, share * z);
      }
      shrunk += line + "\n";
    }
    text = shrunk;
  }
}

// The task's loss without its first and last term: the sum of squared distances, cm².
double CalcTouch(RolloutModel& model) {
  const VectorXd none = VectorXd::Zero(model.num_controls());
  const RecordedRollout rollout = model.Record(MakeInput(model, none), 0.0);
  EXPECT_TRUE(rollout.output.certificate.converged);
  const std::vector<double>& touch = FindSignal(rollout.recording, "touch");
  EXPECT_EQ(touch.size(), 151u);
  double sum = 0.0;
  for (std::size_t k = 5; k <= 75; k += 5) sum += 1e4 * touch[k] * touch[k];
  return sum;
}

// DiffHand: 290.48. The arm sinks, droops, and lies down on the box: what counts is masses, dampings, and at what
// height the tip's underside lies. DiffHand's points of contact reach to 0.7 to 0.85 of the cage's half height (0.9
// to 1.1 cm of 1.3); our links fill their cages, and so come to lie two millimetres higher.
TEST(FlippingOne, InitialDesignWithoutActionTouchesAsDiffHandSays) {
  std::map<std::string, std::string> files = LoadFiles("flipping_one.yaml", MakeDiffHandConstants());
  RolloutModel filled(files);
  EXPECT_NEAR(CalcTouch(filled), 290.48, 0.08 * 290.48);
  ShrinkSections(0.8, &files);
  RolloutModel shrunk(files);
  EXPECT_NEAR(CalcTouch(shrunk), 290.48, 0.02 * 290.48);
  // The rest of the loss: the box stays but for the floor's give.
  const RolloutOutput out = shrunk.Run(MakeInput(shrunk, VectorXd::Zero(shrunk.num_controls())), {});
  EXPECT_NEAR(out.loss - CalcTouch(shrunk), 30 * 50 * (pi / 2) * (pi / 2), 0.01 * 3701.1);
  EXPECT_FALSE(out.success);
}

TEST(FlippingOne, GradientInDesignAndControlsIsThatOfDifferences) {
  RolloutModel model(LoadFiles("flipping_one.yaml", {}));
  ASSERT_EQ(model.num_parameters(), 9);
  ASSERT_EQ(model.num_controls(), 180);
  VectorXd x(189), g(189);
  for (Eigen::Index i = 0; i < 9; ++i) x(i) = 1.0 + 0.05 * std::sin(2.0 * static_cast<double>(i));
  for (Eigen::Index i = 9; i < x.size(); ++i) x(i) = 0.5 * std::sin(0.7 * static_cast<double>(i));
  const auto run = [&](const VectorXd& at, bool gradient) {
    RolloutInput input;
    input.theta = at.head(9);
    input.controls = at.tail(180);
    input.want_gradient = gradient;
    return model.Run(input, {});
  };
  const RolloutOutput out = run(x, true);
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_TRUE(out.gradient_reliable);
  EXPECT_GE(out.certificate.contact_onsets, 1);
  g << out.gradient, out.control_gradient;
  const auto evaluate = [&](const VectorXd& at) { return run(at, false).loss; };
  double worst = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (i >= 9 && i % 11 != 0) continue;  // every eleventh control
    worst = std::max(worst, std::abs(test::CalcDifference(evaluate, x, i, 1e-5) - g(i)));
  }
  // Contact bends the loss: differences over 1e-5 leave some 1e-5 of it.
  EXPECT_LE(worst, 1e-4 * g.lpNorm<Eigen::Infinity>());
}

// ---- The box by itself ----------------------------------------------------------------------------------------------

// With an arm that is far away and stays there.
std::vector<std::string> MakeLonelyBox(const std::vector<std::string>& more) {
  std::vector<std::string> overrides = {"bodies.place.joint.position[0]=1 m"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return overrides;
}

Recording RecordBox(const std::vector<std::string>& overrides) {
  RolloutModel model(LoadFiles("flipping_one.yaml", MakeLonelyBox(overrides)));
  const RecordedRollout rollout = model.Record(MakeInput(model, VectorXd::Zero(model.num_controls())), 0.0);
  EXPECT_TRUE(rollout.output.certificate.converged);
  return rollout.recording;
}

// A hinged cube past its balance is an inverted pendulum: by its energy,
//   omega² = 2 m g r (cos alpha_0 − cos alpha)/I,   r = a/√2,   I = 2/3 m a²,   alpha the angle of its centre from
//   upright.
TEST(FlippingBox, TipsOverItsHingeLikeAnInvertedPendulum) {
  const Recording recording = RecordBox({"bodies.box.joint.damping=0 N*m*s/rad", "bodies.box.initial={angle: 48 deg}",
                                         "rollout.integrator=tr_bdf2", "rollout.tolerance=1e-8"});
  const std::vector<double>& angle = FindSignal(recording, "box_angle");
  std::size_t k = 0;
  for (; k < angle.size() && angle[k] < 85.0 / 180 * pi; ++k) {
    const double alpha_0 = 3.0 / 180 * pi, alpha = angle[k] - pi / 4;
    const double omega_2 =
        2 * kGravity * kSide / std::sqrt(2.0) / (2.0 / 3 * kSide * kSide) * (std::cos(alpha_0) - std::cos(alpha));
    // The rate by central differences of a smooth angle over 10 ms is good to some 1e-3.
    if (k == 0) continue;
    const double rate = (angle[k + 1] - angle[k - 1]) / (recording.time[k + 1] - recording.time[k - 1]);
    EXPECT_NEAR(rate * rate, omega_2, 0.01 * omega_2 + 0.05) << recording.time[k];
  }
  EXPECT_GT(k, 40u);
  EXPECT_LT(k, angle.size());
}

// It comes to rest, turned into the floor by delta, where the floor's pressure holds its weight, about the hinge:
//   m g a/2 (cos delta + sin delta) = E a a³/3 sin delta cos² delta
TEST(FlippingBox, RestsWhereTheFloorHoldsIt) {
  const Recording recording = RecordBox({"bodies.box.initial={angle: 0.5 deg}"});
  double delta = 0.0;
  for (int i = 0; i < 20; ++i) {
    const double weight = kMass * kGravity * kSide / 2 * (std::cos(delta) + std::sin(delta));
    delta = std::asin(weight / (1e6 * std::pow(kSide, 4) / 3 * std::pow(std::cos(delta), 2)));
  }
  const std::vector<double>& angle = FindSignal(recording, "box_angle");
  // What of the far face is in the floor pushes sideways, deep down: some delta² of all.
  EXPECT_NEAR(angle.back(), -delta, 1e-3 * delta);
  for (std::size_t k = 100; k < angle.size(); ++k) EXPECT_NEAR(angle[k], angle.back(), 1e-5) << k;
}

// ---- The arm on the box ---------------------------------------------------------------------------------------------

// The arm lies down on the box and is drawn up and back again: while the box stands level, its upper face presses and
// never pulls, and the box stays behind.
TEST(FlippingOne, TheArmDoesNotStickToTheBox) {
  RolloutModel model(LoadFiles("flipping_one.yaml", {}));
  VectorXd controls = VectorXd::Zero(180);
  for (Eigen::Index i = 0; i < 30; ++i) controls(6 * i + 1) = i < 12 ? 0.0 : 3.0;  // the base, upwards
  const RecordedRollout rollout = model.Record(MakeInput(model, controls), 0.0);
  ASSERT_TRUE(rollout.output.certificate.converged);
  double pressed = 0.0;
  int contacts = 0;
  for (const Recording::Contact& contact : rollout.recording.contacts) {
    if (contact.bodies[1] != "box" || contact.bodies[0] == "box") continue;
    ++contacts;
    for (const Eigen::Vector3d& f_W : contact.f_W) {
      // The box leans by less than 0.03 rad, and friction is at most 1.5 of what presses.
      EXPECT_GE(f_W.z(), -0.05 * f_W.norm() - 1e-12);
      pressed = std::max(pressed, f_W.z());
    }
    EXPECT_EQ(contact.f_W.back().norm(), 0.0) << contact.bodies[0];
  }
  EXPECT_GE(contacts, 1);
  EXPECT_GT(pressed, 0.5);
  const std::vector<double>& angle = FindSignal(rollout.recording, "box_angle");
  for (std::size_t k = 0; k < angle.size(); ++k) EXPECT_LT(std::abs(angle[k]), 0.03) << k;
  EXPECT_GT(FindSignal(rollout.recording, "tip_z").back(), kSide);
}

// ---- The policy -----------------------------------------------------------------------------------------------------

// Commands follow from the state, so the loss' slope in the design does too: without ∂u/∂state it would be another one.
TEST(Flipping, GradientUnderThePolicyIsThatOfDifferences) {
  RolloutModel model(LoadFiles("flipping.yaml", {"policy.initial={type: random, seed: 1, scale: 1}"}));
  ASSERT_EQ(model.num_parameters(), 9);
  VectorXd w(model.num_controls());
  for (Eigen::Index i = 0; i < w.size(); ++i) w(i) = 0.2 * std::sin(1.3 * static_cast<double>(i * i + 1));
  const VectorXd theta = model.initial_theta();
  const auto run = [&](const VectorXd& at, bool gradient) {
    RolloutInput input;
    input.theta = at.head(9);
    input.controls = at.tail(w.size());
    input.variation = {0.17, 0.01, 0.4};
    input.want_gradient = gradient;
    return model.Run(input, {});
  };
  VectorXd x(9 + w.size()), g(9 + w.size());
  x << theta, w;
  x(2) += 0.1;
  const RolloutOutput out = run(x, true);
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_GE(out.certificate.contact_onsets, 1);
  g << out.gradient, out.control_gradient;
  const auto evaluate = [&](const VectorXd& at) { return run(at, false).loss; };
  double worst_design = 0.0, worst_weight = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (i >= 9 && i % 67 != 0) continue;
    double& worst = i < 9 ? worst_design : worst_weight;
    worst = std::max(worst, std::abs(test::CalcDifference(evaluate, x, i, 1e-5) - g(i)));
  }
  EXPECT_LE(worst_design, 1e-4 * g.head(9).lpNorm<Eigen::Infinity>());
  EXPECT_LE(worst_weight, 1e-4 * g.tail(w.size()).lpNorm<Eigen::Infinity>());
}

}  // namespace flipping_test
}  // namespace knap
