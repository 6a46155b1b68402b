#include "sim/scenarios/apply_variation.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace apply_variation_test {

Scene ParseEverything(std::span<const std::string> overrides = {}) {
  ParseResult result = ParseScene(kEverythingYaml, "f.yaml", overrides);
  EXPECT_TRUE(result.ok()) << result.FormatErrors();
  return result.scene;
}

TEST(ApplyVariation, SetsTheVariedNumbersAlone) {
  const Scene scene = ParseEverything();
  Scene varied = scene;
  ApplyVariation(varied, std::vector<double>{0.015, 0.3, 0.0005});
  EXPECT_EQ(std::get<FreeJoint>(varied.bodies.back().joint.kind).initial.position, Eigen::Vector3d(0.015, 0.1, 0.01));
  EXPECT_EQ(varied.contacts[0].friction, 0.3);
  EXPECT_EQ(std::get<NumberTarget>(varied.loss.task[0].target).value, 0.0005);
  Scene original = scene;
  const std::vector<NumericKey> before = ListNumericKeys(original);
  const std::vector<NumericKey> after = ListNumericKeys(varied);
  ASSERT_EQ(before.size(), after.size());
  int changed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) changed += *before[i].value != *after[i].value;
  EXPECT_EQ(changed, 3);
  EXPECT_THROW(ApplyVariation(varied, std::vector<double>{1.0}), std::invalid_argument);
}

// One number of the sample that varies, a value that can be written into a double but not into a file, and why not.
struct RefusedDraw {
  const char* name;
  const char* key;
  double value;
  const char* reason;
};

class Refusal : public testing::TestWithParam<RefusedDraw> {};

TEST_P(Refusal, NamesKeyValueAndReason) {
  Scene scene = ParseEverything();
  scene.variation = {{{GetParam().key}, UniformDistribution{}}};
  try {
    ApplyVariation(scene, std::vector<double>{GetParam().value});
    FAIL() << "allowed";
  } catch (const std::invalid_argument& e) {
    EXPECT_EQ(std::string(e.what()),
              std::string("the variation is not allowed: ") + GetParam().key + GetParam().reason);
  }
}

const RefusedDraw kRefusedDraws[] = {
    {"SamplesBetweenSteps", "loss.distillation[0].when.every", 1e-4,
     " = 1e-04 s: must be a whole number of steps of 0.002 s"},
    {"SamplesBeyondTheEnd", "loss.task[3].when.every", 1.5,
     " = 1.5 s: no sample lies between 0 s and 1 s; one comes every 1.5 s"},
    {"RampOverHalf", "bodies.hand.joint.motion.segments[0].ramp", 0.6,
     " = 0.6 s: must be at most half the duration, 0.5 s"},
    {"DurationUnderTwoRamps", "bodies.hand.joint.motion.segments[1].duration", 1.0,
     " = 1 s: bodies.hand.joint.motion.segments[1].ramp: must be at most half the duration, 0.5 s"},
    {"BoxThinnerThanItsRounding", "bodies.brick.shapes[0].size[1]", 1e-3,
     " = 0.001 m: bodies.brick.shapes[0].rounding: must be at most half the least size, 5e-04 m"},
    {"LimitsCross", "bodies.hinge.joint.limits.lower", 2.0,
     " = 2 rad: must be less than upper, 1.5707963267948966 rad"},
    {"TargetsCross", "bodies.slider.joint.actuator.upper", -0.01,
     " = -0.01 m: bodies.slider.joint.actuator.lower: must be less than upper, -0.01 m"},
    {"NoAxis", "bodies.slider.joint.axis[2]", 0.0, " = 0: bodies.slider.joint.axis: must not be zero"},
    {"NoSuchInertia", "bodies.hinge.inertia.moments[0]", 7e-6,
     " = 7e-06 kg*m^2: bodies.hinge.inertia.moments: no body has such moments: the principal ones are 2.998e-06, "
     "3e-06 and 7.002e-06, but each must be positive and no larger than the sum of the others"},
    {"LetsGoBeforeItHolds", "grips[0].until", 0.2, " = 0.2 s: must be more than `from`, 0.25 s"},
    {"OffTheRope", "grips[0].held_point[0]", 0.07, " = 0.07 m: must lie on the rope, from 0 m to 0.06 m"},
    {"NoSampleInTime", "loss.task[1].when.until", 0.1,
     " = 0.1 s: loss.task[1].when.every: no sample lies between 0.08 s and 0.1 s; one comes every 0.04 s"},
    {"PlacesOutOfOrder", "signals.pill_error.targets[1].after", 0.0, " = 0 s: must be later than the one before"},
    {"ValuesOutOfOrder", "loss.task[4].target.values[1].after", 0.6,
     " = 0.6 s: loss.task[4].target.values[2].after: must be later than the one before"},
    {"DriftBetweenSteps", "signals.rope_drift.since", 0.081, " = 0.081 s: must be a whole number of steps of 0.002 s"},
    {"BoundsUpsideDown", "success.of[0].below", -0.03, " = -0.03 m: success.of[0].above: must be less than `below`"},
    {"LastsLongerThanItsSpan", "success.of[1].of[2].when.duration", 0.7, " = 0.7 s: must fit into the span, 0.65 s"},
    {"OutOfItsRange", "contacts[0].friction", -0.1, " = -0.1: must be from 0 to 10"},
    {"NotFinite", "gravity[2]", std::numeric_limits<double>::infinity(), " = inf m/s^2: must be finite"},
    {"NotANumber", "gravity[2]", std::numeric_limits<double>::quiet_NaN(), " = nan m/s^2: must be finite"},
};

INSTANTIATE_TEST_SUITE_P(Draws, Refusal, testing::ValuesIn(kRefusedDraws),
                         [](const testing::TestParamInfo<RefusedDraw>& draw) { return draw.param.name; });

}  // namespace apply_variation_test
}  // namespace knap
