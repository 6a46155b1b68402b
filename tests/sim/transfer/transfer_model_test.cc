// Motions in Bullet that have closed forms, of scenes as a user writes them. Bullet's step is semi-implicit and of
// first order: tolerances are what a step of 0.5 ms is worth, or a share of the closed form where that is said.
#include "sim/transfer/transfer_model.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/math/smooth_ramp.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "sim/transfer/contact_law.h"
#include "sim/transfer/soft_links.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kG = 9.81;
constexpr double kStep = 5e-4;

// `world`: all of the scene but its head and rollout.
TransferModel MakeModel(const std::string& world, double horizon,
                        const std::string& gravity = "0 m/s^2, 0 m/s^2, -9.81 m/s^2") {
  return TransferModel(
      {{kScenarioFileName,
        fmt::format("schema: 2\nname: transfer\ngravity: [{}]\nrollout: {{horizon: {} s, step: 10 ms}}\n{}", gravity,
                    horizon, world)}});
}

Vector3d GetPosition(const TransferModel& model, const std::string& body, int k) {
  return model.history()
      .states[static_cast<std::size_t>(k)]
      .X_WB[static_cast<std::size_t>(model.model().body_index.at(body))]
      .p;
}
Vector3d GetLast(const TransferModel& model, const std::string& body) {
  return GetPosition(model, body, static_cast<int>(model.history().time.size()) - 1);
}
// v_WBo_W.
Vector3d GetLastVelocity(const TransferModel& model, const std::string& body) {
  const auto i = static_cast<std::size_t>(model.model().body_index.at(body));
  const BodyHistory::State& state = model.history().states.back();
  return state.X_WB[i].R * state.V[i].tail<3>();
}

constexpr const char* kFloor = "  - {name: floor, joint: {type: fixed}, shapes: [{type: half_space}]}\n";

std::string MakeBall(const std::string& initial) {
  return fmt::format(
      "  - name: ball\n    joint: {{type: free}}\n    shapes: [{{type: sphere, radius: 10 mm}}]\n"
      "    inertia: {{type: solid, mass: 4 g}}\n    initial: {{{}}}\n",
      initial);
}

std::string MakeBallOnFloor(const std::string& initial, const std::string& contact) {
  return fmt::format("bodies:\n{}{}contacts:\n  - {{bodies: [ball, floor], stiffness: 3e7 N/m^3, {}}}\n", kFloor,
                     MakeBall(initial), contact);
}

TEST(TransferModel, WhatFallsFollowsAParabolaAndTurnsEvenly) {
  // Its centre of mass lies beside Bo, which therefore circles it.
  TransferModel model = MakeModel(
      "bodies:\n  - name: stone\n    joint: {type: free}\n"
      "    inertia: {type: explicit, mass: 10 g, center: [5 mm, 0 mm, 0 mm], moments: [1e-6 kg*m^2, 2e-6 kg*m^2, 3e-6 "
      "kg*m^2]}\n"
      "    initial: {position: [10 mm, 0 mm, 50 mm], velocity: [300 mm/s, 20 mm/s, 1 m/s], angular_velocity: [0 rad/s, "
      "0 "
      "rad/s, 6 rad/s]}\n",
      0.5);
  const TransferOutput out = model.Run({}, {}, {});
  EXPECT_TRUE(out.finite);
  EXPECT_EQ(out.steps, 1000);
  const double t = 0.5, w = 6.0, c = 5e-3;
  // The centre's velocity is that of Bo and w × c.
  const Vector3d center(10e-3 + c + 0.3 * t, (0.02 + w * c) * t, 50e-3 + t - 0.5 * kG * t * t);
  const Vector3d expected = center - c * Vector3d(std::cos(w * t), std::sin(w * t), 0.0);
  EXPECT_LT((GetLast(model, "stone") - expected).norm(), kG * t * kStep);
  // The scheme's own error is known: g t h/2.
  EXPECT_NEAR(GetLast(model, "stone").z(), expected.z() - 0.5 * kG * t * kStep, 1e-9);
  EXPECT_NEAR(GetLast(model, "stone").y(), expected.y(), 1e-6);
  EXPECT_NEAR(model.history().states.back().V.back()(2), w, 1e-6);
}

// A block on a plane that is tilted, i.e. gravity is.
double SlideFor(double slope_of_friction, double friction, double time) {
  const double angle = std::atan(slope_of_friction * friction);
  TransferModel model = MakeModel(
      fmt::format(
          "bodies:\n{}  - name: block\n    joint: {{type: free}}\n    shapes: [{{type: box, size: [30 mm, 40 mm, 20 "
          "mm]}}]\n    inertia: {{type: solid, mass: 50 g}}\n    initial: {{position: [0 mm, 0 mm, 10 mm], "
          "orientation_rpy: [0 deg, 0 deg, 20 deg]}}\n"
          "contacts:\n  - {{bodies: [block, floor], stiffness: 3e7 N/m^3, damping: 10 s/m, friction: {}}}\n",
          kFloor, friction),
      time, fmt::format("{} m/s^2, 0 m/s^2, {} m/s^2", kG * std::sin(angle), -kG * std::cos(angle)));
  const TransferOutput out = model.Run({}, {}, {});
  EXPECT_TRUE(out.finite);
  EXPECT_TRUE(out.distrust.empty());
  EXPECT_NEAR(GetLast(model, "block").z(), 0.01, 1e-5);
  EXPECT_NEAR(GetLast(model, "block").y(), 0.0, 1e-5);
  return GetLast(model, "block").x();
}

TEST(TransferModel, ABlockSticksBelowTheAngleOfFrictionAndSlidesAboveIt) {
  for (const double friction : {0.2, 0.6}) {
    EXPECT_LT(std::abs(SlideFor(0.9, friction, 1.0)), 1e-4) << friction;
    const double angle = std::atan(1.2 * friction);
    const double expected = 0.5 * kG * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(SlideFor(1.2, friction, 1.0), expected, 5e-3 * expected) << friction;
  }
}

// A block that slides along y and is drawn aside by half of what friction can hold: dv/dt = (a, 0) − μ g v/|v|.
TEST(TransferModel, WhatSlidesDoesNotStickAcrossItsWay) {
  const double friction = 0.3, angle = std::atan(0.5 * friction), time = 0.2;
  TransferModel model = MakeModel(
      fmt::format(
          "bodies:\n{}  - name: block\n    joint: {{type: free}}\n    shapes: [{{type: box, size: [60 mm, 60 mm, 10 "
          "mm]}}]\n    inertia: {{type: solid, mass: 50 g}}\n    initial: {{position: [0 mm, 0 mm, 5 mm], velocity: "
          "[0 m/s, 1 m/s, 0 m/s]}}\ncontacts:\n  - {{bodies: [block, floor], stiffness: 3e7 N/m^3, damping: 100 "
          "s/m, friction: {}}}\n",
          kFloor, friction),
      time, fmt::format("{} m/s^2, 0 m/s^2, {} m/s^2", kG * std::sin(angle), -kG * std::cos(angle)));
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  Vector3d v(0.0, 1.0, 0.0), x = Vector3d::Zero();
  for (int i = 0; i < 200000; ++i) {
    v += 1e-6 * kG * (std::sin(angle) * Vector3d::UnitX() - friction * std::cos(angle) * v.normalized());
    x += 1e-6 * v;
  }
  EXPECT_GT(x.x(), 0.02);
  EXPECT_LT((GetLast(model, "block") - x - Vector3d(0.0, 0.0, 0.005)).norm(), 0.02 * x.x());
}

// The rebound of a contact F = K depth D(1 + d ddepth/dt), by integrating its motion in small steps.
double IntegrateRebound(double d, double v) {
  const double K = 1e4, h = 1e-6;
  double depth = 0.0, speed = v;
  const auto slope = [&](double x, double u) { return -K * x * CalcSmoothRamp(1.0 + d * u, 1.0).value; };
  while (depth >= 0.0) {
    const double middle = speed + 0.5 * h * slope(depth, speed);
    const double force = slope(depth + 0.5 * h * speed, middle);
    depth += h * middle;
    speed += h * force;
  }
  return -speed / v;
}

// What knap's own engine makes of the same drop: the height of the first rebound.
double ReboundInKnap(const std::string& world, double fall, double horizon) {
  RolloutModel model(
      {{kScenarioFileName,
        fmt::format("schema: 2\nname: drop\ngravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]\nrollout: {{horizon: {} s, "
                    "step: 2 ms}}\n{}",
                    horizon, world)}});
  const RecordedRollout record = model.Record({}, 0.0);
  double top = 0.0;
  for (std::size_t k = 0; k < record.recording.time.size(); ++k) {
    if (record.recording.time[k] > fall + 5e-3) top = std::max(top, record.recording.Find("ball").X_WB[k].p.z() - 0.01);
  }
  return top;
}

TEST(TransferModel, ABallReboundsAsItsContactDampingSays) {
  for (const double d : {0.0, 0.3, 10.0}) {
    const double v = std::sqrt(2.0 * kG * 0.05);
    const double e = IntegrateRebound(d, v);
    EXPECT_NEAR(CalcRebound(d, v), e, 2e-4) << d;
    // Falls by 50 mm, then rises by e² times that.
    const double fall = v / kG;
    TransferModel model = MakeModel(MakeBallOnFloor("position: [0 mm, 0 mm, 60 mm]", fmt::format("damping: {} s/m", d)),
                                    std::ceil(100.0 * (fall + e * fall)) / 100.0);
    EXPECT_TRUE(model.Run({}, {}, {}).finite);
    double top = 0.0;
    for (std::size_t k = 0; k < model.history().time.size(); ++k) {
      if (model.history().time[k] > fall + 2e-3)
        top = std::max(top, GetPosition(model, "ball", static_cast<int>(k)).z() - 0.01);
    }
    // A step of fall more or less, and samples of 10 ms about the top.
    EXPECT_NEAR(top, 0.05 * e * e, 2.0 * v * kStep + 0.125 * kG * 1e-4) << d;
    // knap's contact is soft, so that gravity works a little on the way.
    const double soft =
        ReboundInKnap(MakeBallOnFloor("position: [0 mm, 0 mm, 60 mm]", fmt::format("damping: {} s/m", d)), fall,
                      std::ceil(100.0 * (fall + e * fall)) / 100.0);
    EXPECT_NEAR(soft, 0.05 * e * e, 0.03 * 0.05) << d;
  }
}

TEST(TransferModel, ARollingBallIsBrakedAlongItsWayWhereverThatLeads) {
  const double v = 0.3, r = 0.01, resistance = 0.05;
  const Vector3d direction(0.8, 0.6, 0.0);
  const Vector3d w = Vector3d::UnitZ().cross(direction) * (v / r);
  const double deceleration = 5.0 / 7.0 * resistance * kG;
  const double time = 0.5;
  TransferModel model = MakeModel(
      MakeBallOnFloor(
          fmt::format("position: [0 mm, 0 mm, 10 mm], velocity: [{} m/s, {} m/s, 0 m/s], angular_velocity: [{} "
                      "rad/s, {} rad/s, 0 rad/s]",
                      v * direction.x(), v * direction.y(), w.x(), w.y()),
          fmt::format("damping: 10 s/m, friction: 0.4, rolling_resistance: {}", resistance)),
      time);
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  const Vector3d moved = GetLast(model, "ball") - Vector3d(0.0, 0.0, r);
  const double expected = v * time - 0.5 * deceleration * time * time;
  EXPECT_NEAR(moved.dot(direction), expected, 0.01 * expected);
  EXPECT_LT((moved - moved.dot(direction) * direction).norm(), 0.01 * expected);
  // And comes to rest after v/deceleration = 0.86 s.
  TransferModel longer = MakeModel(
      MakeBallOnFloor(
          fmt::format("position: [0 mm, 0 mm, 10 mm], velocity: [{} m/s, {} m/s, 0 m/s], angular_velocity: [{} "
                      "rad/s, {} rad/s, 0 rad/s]",
                      v * direction.x(), v * direction.y(), w.x(), w.y()),
          fmt::format("damping: 10 s/m, friction: 0.4, rolling_resistance: {}", resistance)),
      1.5);
  EXPECT_TRUE(longer.Run({}, {}, {}).finite);
  EXPECT_NEAR(GetLast(longer, "ball").head<2>().norm(), 0.5 * v * v / deceleration, 0.01 * v * v / deceleration);
  EXPECT_LT(GetLastVelocity(longer, "ball").norm(), 1e-3);
}

TEST(TransferModel, ASlidingBallEndsUpRollingAtFiveSevenths) {
  TransferModel model =
      MakeModel(MakeBallOnFloor("position: [0 mm, 0 mm, 10 mm], velocity: [300 mm/s, 400 mm/s, 0 m/s]",
                                "damping: 10 s/m, friction: 0.4"),
                0.5);
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  EXPECT_LT((GetLastVelocity(model, "ball") - 5.0 / 7.0 * Vector3d(0.3, 0.4, 0.0)).norm(), 0.01 * 0.5);
}

TEST(TransferModel, AKinematicBodyTakesABlockAlong) {
  TransferModel model = MakeModel(
      fmt::format(
          "bodies:\n{}  - name: plate\n    joint: {{type: prescribed, motion: {{type: constant_velocity, velocity: [50 "
          "mm/s, 0 mm/s, 0 mm/s]}}}}\n    shapes: [{{type: box, size: [10 mm, 100 mm, 40 mm], position: [-5 mm, 0 mm, "
          "20 mm]}}]\n  - name: block\n    joint: {{type: free}}\n    shapes: [{{type: box, size: [30 mm, 40 mm, 20 "
          "mm]}}]\n    inertia: {{type: solid, mass: 50 g}}\n    initial: {{position: [20 mm, 0 mm, 10 mm]}}\n"
          "contacts:\n  - {{bodies: [block, floor], stiffness: 3e7 N/m^3, damping: 100 s/m, friction: 0.3}}\n"
          "  - {{bodies: [block, plate], stiffness: 3e7 N/m^3, damping: 100 s/m, friction: 0.3}}\n",
          kFloor),
      1.0);
  const TransferOutput out = model.Run({}, {}, {});
  EXPECT_TRUE(out.finite);
  EXPECT_LT(out.penetration, 0.02);
  EXPECT_NEAR(GetLast(model, "plate").x(), 0.05, 1e-12);
  EXPECT_NEAR(GetLast(model, "block").x(), 0.05 + 0.015, 2e-4);
}

// ---- Ropes and grips ----------------------------------------------------------------------------------------------

std::string MakeHangingRope(int links, double stiffness, double damping, const std::string& more = "") {
  return fmt::format(
      "bodies:\n  - {{name: hook, joint: {{type: fixed, position: [0 mm, 0 mm, 0 mm]}}}}\n"
      "ropes:\n  - {{name: rope, links: {}, pitch: 30 mm, thickness: 8 mm, gap: 1 mm, link_mass: 1.5 g, joint_damping: "
      "2e-5 "
      "N*m*s/rad, initial: {{type: straight, start: [0 mm, 0 mm, 0 mm], direction: [0, 0, -1]}}}}\n"
      "grips:\n  - {{body: hook, held: rope, held_point: [0 mm, 0 mm, 0 mm], stiffness: {} N/m, damping: {} N*s/m, "
      "until: 10 s{}}}\n",
      links, stiffness, damping, more);
}

double GetRopeEnd(const TransferModel& model, int k) {
  return model.history()
      .states[static_cast<std::size_t>(k)]
      .X_WB[static_cast<std::size_t>(model.model().links.at("rope")[0])]
      .p.z();
}

TEST(TransferModel, ARopeStretchesTheSpringOfItsGripByItsWeight) {
  TransferModel model = MakeModel(MakeHangingRope(5, 200.0, 1.0), 2.0);
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  const double expected = -5 * 1.5e-3 * kG / 200.0;
  EXPECT_NEAR(GetRopeEnd(model, 200), expected, 0.01 * std::abs(expected));
  // The links hang together.
  const BodyHistory::State& last = model.history().states.back();
  const std::vector<int>& links = model.model().links.at("rope");
  for (std::size_t i = 1; i < links.size(); ++i) {
    const Pose& before = last.X_WB[static_cast<std::size_t>(links[i - 1])];
    EXPECT_LT((before * Vector3d(0.03, 0.0, 0.0) - last.X_WB[static_cast<std::size_t>(links[i])].p).norm(), 1e-4) << i;
  }
}

TEST(TransferModel, AGripSwingsWithThePeriodOfItsSpringAndLetsGo) {
  // One link falls from the spring's rest: z = −(m g/k)(1 − cos ωt); a full period after, it is back.
  const double k = 20.0, m = 1.5e-3;
  const double period = 2.0 * M_PI * std::sqrt(m / k);  // 54.4 ms
  TransferModel model = MakeModel(MakeHangingRope(1, k, 0.0), 0.06);
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  for (const int n : {1, 2, 3, 4, 5}) {
    // The implicit step damps: by a share ω h/2 a radian.
    const double w = 2.0 * M_PI / period, t = 0.01 * n;
    EXPECT_NEAR(GetRopeEnd(model, n), -m * kG / k * (1.0 - std::cos(w * t)), m * kG / k * w * t * w * kStep) << n;
  }
  TransferModel released = MakeModel(MakeHangingRope(1, 1e4, 10.0), 0.5);
  EXPECT_TRUE(released.Run({}, {}, {}).finite);
  EXPECT_NEAR(GetRopeEnd(released, 50), 0.0, 1e-4);
}

TEST(TransferModel, AGripPullsFromAfarWithItsLimitAndThenLetsGo) {
  // 2 N on one link, nearly constant at 1 m: x = t² F/(2 m); the link turns about its end, so that its centre is what
  // counts.
  const std::string text =
      "bodies:\n  - {name: hook, joint: {type: fixed, position: [10 m, 0 mm, 0 mm]}}\n"
      "ropes:\n  - {name: rope, links: 1, pitch: 30 mm, thickness: 8 mm, gap: 1 mm, link_mass: 1.5 g, initial: {type: "
      "straight, start: [0 mm, 0 mm, 0 mm], direction: [1, 0, 0]}}\n"
      "grips:\n  - {body: hook, held: rope, held_point: [15 mm, 0 mm, 0 mm], stiffness: 200 N/m, limit: 2 mN, until: "
      "0.5 s}\n";
  TransferModel model = MakeModel(text, 1.0, "0 m/s^2, 0 m/s^2, 0 m/s^2");
  EXPECT_TRUE(model.Run({}, {}, {}).finite);
  const double a = 2e-3 / 1.5e-3;
  const auto& at = [&](int k) { return model.history().states[static_cast<std::size_t>(k)].X_WB[1 + 1].p.x(); };
  EXPECT_NEAR(at(50), 0.5 * a * 0.25, 2e-3 * a);
  EXPECT_NEAR(at(100) - at(50), a * 0.5 * 0.5, 2e-3 * a);
}

TEST(DampJoints, KeepsAngularMomentumAndBrakesTheDifferenceExactly) {
  const double a = 0.3;
  const Matrix3d I1 = Vector3d(1.0, 2.0, 3.0).asDiagonal(), I2 = Vector3d(4.0, 5.0, 6.0).asDiagonal();
  std::vector<Vector3d> w = {Vector3d(1.0, 0.5, -2.0), Vector3d(-1.0, 3.0, 0.0)};
  const std::vector<Vector3d> before = w;
  DampJoints(a, {I1, I2}, &w);
  EXPECT_LT((I1 * w[0] + I2 * w[1] - I1 * before[0] - I2 * before[1]).norm(), 1e-12);
  for (int i = 0; i < 3; ++i) {
    const double rate = a * (1.0 / I1(i, i) + 1.0 / I2(i, i));
    EXPECT_NEAR(w[0](i) - w[1](i), (before[0](i) - before[1](i)) / (1.0 + rate), 1e-12);
  }
  // More links: the equations themselves.
  std::vector<Matrix3d> I;
  std::vector<Vector3d> u;
  for (int i = 0; i < 5; ++i) {
    const Matrix3d R = Eigen::AngleAxisd(0.7 * i, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    I.push_back(R * Vector3d(1.0, 0.1, 2.0 + i).asDiagonal() * R.transpose());
    u.push_back(Vector3d(std::sin(i), std::cos(2.0 * i), 1.0 - i));
  }
  const std::vector<Vector3d> u0 = u;
  DampJoints(a, I, &u);
  for (int i = 0; i < 5; ++i) {
    Vector3d residual = I[i] * (u[i] - u0[i]);
    if (i > 0) residual += a * (u[i] - u[i - 1]);
    if (i < 4) residual += a * (u[i] - u[i + 1]);
    EXPECT_LT(residual.norm(), 1e-12) << i;
  }
}

// ---- Judgement, determinism, refusals ------------------------------------------------------------------------------

constexpr const char* kJudged =
    "signals:\n  - {name: z, type: position, body: ball, axis: z}\n  - {name: touch, type: depth, bodies: [ball, "
    "floor]}\n"
    "loss:\n  task:\n    - {signals: [z], when: {type: at, time: 50 ms}, scale: 1 m}\n"
    "success:\n  type: all\n  of:\n"
    "    - {type: within, signals: [touch], above: 0 mm, when: {type: ever, from: 0.9 s}}\n"
    "    - {type: within, signals: [z], below: 10.1 mm, when: {type: lasting, duration: 500 ms}}\n"
    "    - {type: none, of: [{type: within, signals: [touch], above: 0 mm, when: {type: ever, until: 50 ms}}]}\n"
    "    - {type: within, signals: [z], above: 19.9 mm, below: 20.1 mm, when: {type: crossing, signal: z, at: 20 "
    "mm}}\n";

TEST(TransferModel, TheSameTermsAndConditionsJudgeItsTrajectory) {
  const std::string world =
      MakeBallOnFloor("position: [0 mm, 0 mm, 30 mm]", "damping: 100 s/m, friction: 0.3") + kJudged;
  TransferModel model = MakeModel(world, 1.0);
  const TransferOutput out = model.Run({}, {}, {});
  EXPECT_TRUE(out.success);
  const double z = 0.03 - 0.5 * kG * 0.05 * 0.05;
  EXPECT_NEAR(out.loss, z * z, 1e-3 * z * z + 2.0 * z * kG * 0.05 * kStep);
  EXPECT_EQ(out.contact_onsets > 0, true);
  // From so high it does not reach the floor.
  TransferModel without =
      MakeModel(MakeBallOnFloor("position: [0 mm, 0 mm, 5.2 m]", "damping: 100 s/m") + kJudged, 1.0);
  EXPECT_FALSE(without.Run({}, {}, {}).success);
}

TEST(TransferModel, NothingOfOneRolloutSurvivesIntoTheNext) {
  const std::string world =
      MakeBallOnFloor("position: [0 mm, 0 mm, 30 mm], velocity: [100 mm/s, 0 m/s, 0 m/s]",
                      "damping: 3 s/m, friction: 0.3, rolling_resistance: 0.05") +
      kJudged +
      "variation:\n  - {key: \"bodies.ball.initial.position[2]\", distribution: uniform, lower: 20 mm, upper: 40 mm}\n";
  TransferModel model = MakeModel(world, 1.0), fresh = MakeModel(world, 1.0);
  const double first = model.Run({}, {0.03}, {}).loss;
  EXPECT_NE(model.Run({}, {0.035}, {}).loss, first);
  EXPECT_EQ(model.Run({}, {0.03}, {}).loss, first);
  const BodyHistory again = model.history();
  EXPECT_EQ(fresh.Run({}, {0.03}, {}).loss, first);
  for (std::size_t k = 0; k < again.states.size(); ++k) {
    EXPECT_EQ(again.states[k].X_WB.back().p, fresh.history().states[k].X_WB.back().p);
    EXPECT_EQ(again.states[k].V.back(), fresh.history().states[k].V.back());
  }
}

std::string Refuse(const std::string& world) {
  try {
    MakeModel(world, 0.1);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(TransferModel, RefusesByNameWhatBulletCannotRepresent) {
  using ::testing::HasSubstr;
  EXPECT_THAT(
      Refuse("bodies:\n  - {name: door, joint: {type: revolute, axis: [0, 0, 1]}, inertia: {type: explicit, mass: 1 "
             "kg, moments: [1 kg*m^2, 1 kg*m^2, 1 kg*m^2]}}\n"),
      HasSubstr("bodies.door.joint.type: the engine bullet has no revolute joints"));
  EXPECT_THAT(Refuse(fmt::format("bodies:\n{}{}  - {{name: flag, parent: ball, joint: {{type: fixed}}}}\n", kFloor,
                                 MakeBall("position: [0 mm, 0 mm, 30 mm]"))),
              HasSubstr("bodies.flag.parent: the engine bullet has no bodies that hang on a free one, 'ball'"));
  EXPECT_THAT(Refuse(MakeBallOnFloor("position: [0 mm, 0 mm, 30 mm]", "damping: 3 s/m") +
                     "signals:\n  - {name: f, type: force, bodies: [ball, floor]}\n"),
              HasSubstr("signals.f: the engine bullet has rigid contacts, whose forces are no signals"));
}

}  // namespace
}  // namespace knap
