// Conditions of success on motions that are known: a body that moves evenly, one that swings, a ball that bounces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace conditions_test {

// cart: x = 100 mm/s · t; shuttle: x goes from 0 to 40 mm in 0.2 s, stands for 0.2 s, goes back in 0.2 s and stands;
// ball: falls 20 mm, stops and stays at rest, in touch with the floor from some 64 ms on.
bool Succeeds(const std::string& success, const std::string& integrator = "tr_bdf2") {
  const std::string text = fmt::format(
      R"(schema: 2
name: conditions
bodies:
  - {{name: floor, joint: {{type: fixed}}, shapes: [{{type: half_space}}]}}
  - name: cart
    joint: {{type: prescribed, motion: {{type: constant_velocity, velocity: [100 mm/s, 0 mm/s, 0 mm/s]}}}}
  - name: shuttle
    joint:
      type: prescribed
      motion:
        type: segments
        segments:
          - {{duration: 200 ms, ramp: 50 ms, shift: [40 mm, 0 mm, 0 mm]}}
          - {{duration: 200 ms, ramp: 50 ms}}
          - {{duration: 200 ms, ramp: 50 ms, shift: [-40 mm, 0 mm, 0 mm]}}
          - {{duration: 200 ms, ramp: 50 ms}}
  - name: ball
    joint: {{type: free}}
    shapes: [{{type: sphere, radius: 10 mm}}]
    inertia: {{type: solid, mass: 4 g}}
    initial: {{position: [0 mm, 50 mm, 30 mm]}}
contacts:
  - {{bodies: [ball, floor], stiffness: 3e7 N/m^3, damping: 100 s/m}}
rollout: {{horizon: 800 ms, step: 10 ms, integrator: {}}}
signals:
  - {{name: x, type: position, body: cart, axis: x}}
  - {{name: y, type: position, body: cart, axis: y}}
  - {{name: s, type: position, body: shuttle, axis: x}}
  - {{name: depth, type: depth, bodies: [floor, ball]}}
  - {{name: force, type: force, bodies: [ball, floor]}}
  - {{name: height, type: position, body: ball, axis: z}}
success: {}
)",
      integrator, success);
  RolloutModel model({{kScenarioFileName, text}});
  const RolloutOutput out = model.Run({}, {});
  EXPECT_TRUE(out.certificate.converged);
  EXPECT_TRUE(out.distrust.empty());
  return out.success;
}

TEST(Conditions, AtTheEndAndAtATime) {
  EXPECT_TRUE(Succeeds("{type: within, signals: [x], above: 79 mm, below: 81 mm}"));
  EXPECT_FALSE(Succeeds("{type: within, signals: [x], above: 81 mm}"));
  EXPECT_FALSE(Succeeds("{type: within, signals: [x], below: 79 mm}"));
  EXPECT_FALSE(Succeeds("{type: within, signals: [x, y], above: 79 mm}"));  // every one of them
  EXPECT_TRUE(Succeeds("{type: within, signals: [x, y], above: -1 mm, below: 81 mm}"));
  EXPECT_TRUE(Succeeds("{type: within, signals: [x], above: 29 mm, below: 31 mm, when: {type: at, time: 300 ms}}"));
  EXPECT_FALSE(Succeeds("{type: within, signals: [x], above: 31 mm, when: {type: at, time: 300 ms}}"));
}

TEST(Conditions, EverAlwaysAndForADuration) {
  const auto s = [](const std::string& rest) { return "{type: within, signals: [s], " + rest + "}"; };
  EXPECT_TRUE(Succeeds(s("above: 39 mm, when: {type: ever}")));
  EXPECT_FALSE(Succeeds(s("above: 41 mm, when: {type: ever}")));
  EXPECT_FALSE(Succeeds(s("above: 39 mm, when: {type: ever, from: 500 ms}")));
  EXPECT_TRUE(Succeeds(s("above: -1 mm, below: 41 mm, when: {type: always}")));
  EXPECT_FALSE(Succeeds(s("below: 39 mm, when: {type: always}")));
  EXPECT_TRUE(Succeeds(s("below: 39 mm, when: {type: always, from: 450 ms, until: 750 ms}")));
  EXPECT_FALSE(Succeeds(s("below: 50 mm, when: {type: always, from: 452 ms, until: 458 ms}"), "bdf1"));  // no state
  // Above 39 mm for somewhat more than the 200 ms that it stands there.
  EXPECT_TRUE(Succeeds(s("above: 39 mm, when: {type: lasting, duration: 200 ms}")));
  EXPECT_FALSE(Succeeds(s("above: 39 mm, when: {type: lasting, duration: 300 ms}")));
  // Near 0 twice, but not for so long at once.
  EXPECT_FALSE(Succeeds(s("below: 1 mm, when: {type: lasting, duration: 260 ms}")));
  EXPECT_TRUE(Succeeds(s("below: 1 mm, when: {type: lasting, duration: 200 ms, from: 550 ms}")));
}

TEST(Conditions, AtACrossing) {
  // s is 40 mm when x crosses 30 mm at 0.3 s, and on the way when it crosses 10 mm at 0.1 s.
  const auto at = [](const std::string& x, const std::string& bounds) {
    return Succeeds("{type: within, signals: [s], " + bounds + ", when: {type: crossing, signal: x, at: " + x + "}}");
  };
  EXPECT_TRUE(at("30 mm", "above: 39.9 mm, below: 40.1 mm"));
  EXPECT_TRUE(at("10 mm", "above: 19.9 mm, below: 20.1 mm"));
  EXPECT_FALSE(at("10 mm", "above: 20.1 mm"));
  EXPECT_FALSE(at("90 mm", "above: -1 m"));  // never crosses
}

TEST(Conditions, AllAnyAndNone) {
  const std::string yes = "{type: within, signals: [x], above: 79 mm}",
                    no = "{type: within, signals: [x], below: 0 mm}";
  EXPECT_TRUE(Succeeds("{type: all, of: [" + yes + ", " + yes + "]}"));
  EXPECT_FALSE(Succeeds("{type: all, of: [" + yes + ", " + no + "]}"));
  EXPECT_TRUE(Succeeds("{type: any, of: [" + no + ", " + yes + "]}"));
  EXPECT_FALSE(Succeeds("{type: any, of: [" + no + ", " + no + "]}"));
  EXPECT_TRUE(Succeeds("{type: none, of: [" + no + ", " + no + "]}"));
  EXPECT_FALSE(Succeeds("{type: none, of: [" + no + ", " + yes + "]}"));
  EXPECT_TRUE(
      Succeeds("{type: all, of: [{type: any, of: [" + no + ", " + yes + "]}, {type: none, of: [" + no + "]}]}"));
}

TEST(Conditions, OfContacts) {
  for (const char* integrator : {"tr_bdf2", "bdf2"}) {
    EXPECT_FALSE(
        Succeeds("{type: within, signals: [depth], above: 0 mm, when: {type: ever, until: 50 ms}}", integrator));
    EXPECT_TRUE(
        Succeeds("{type: within, signals: [depth], above: 0 mm, when: {type: ever, until: 80 ms}}", integrator));
    // At rest the floor bears the ball.
    EXPECT_TRUE(Succeeds("{type: within, signals: [force], above: 39 mN, below: 39.5 mN}", integrator));
    EXPECT_TRUE(Succeeds("{type: within, signals: [height], below: 9.9 mm, above: 9.7 mm}", integrator));
  }
}

}  // namespace conditions_test
}  // namespace knap
