// Draws are tried before a rollout: alone at both ends and between, together at the corners.
#include "sim/scenarios/check_variation.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/sim/scenarios/edited_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace {

constexpr char kFirstVariation[] =
    "  - {key: \"bodies.pea.initial.position[0]\", distribution: uniform, lower: -20 mm, upper: 20 mm}\n";

std::string ParseWithVariations(const std::string& variations, std::string* place) {
  const EditedScene scene = EditScene(kEverythingYaml, kFirstVariation, variations);
  *place = "f.yaml:" + scene.place + ": ";
  return ParseEditedScene(scene);
}

TEST(CheckVariation, RefusesALowerEnd) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: \"loss.distillation[0].when.every\", distribution: uniform, lower: @0.1 ms, upper: 20 ms}\n", &place);
  EXPECT_EQ(errors, place +
                        "variation[0].lower: value '0.1 ms': this can be drawn and is not allowed: "
                        "loss.distillation[0].when.every = 1e-04 s: must be a whole number of steps of 0.002 s\n");
}

TEST(CheckVariation, RefusesAnUpperEnd) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: \"bodies.hand.joint.motion.segments[0].ramp\", distribution: uniform, lower: 0.1 s, upper: @0.7 s}\n",
      &place);
  EXPECT_EQ(errors,
            place +
                "variation[0].upper: value '0.7 s': this can be drawn and is not allowed: "
                "bodies.hand.joint.motion.segments[0].ramp = 0.7 s: must be at most half the duration, 0.5 s\n");
}

// The lower end of a normal distribution comes from three fields; its spread is what reaches too far.
TEST(CheckVariation, RefusesTheReachOfANormalDistribution) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: \"bodies.brick.shape.size[1]\", distribution: normal, mean: 8 mm, std: @2.2 mm}\n", &place);
  EXPECT_TRUE(errors.starts_with(place + "variation[0].std: value '2.2 mm': this can be drawn and is not allowed: "
                                         "bodies.brick.shape.size[1] = 0.00"))
      << errors;
  EXPECT_NE(errors.find("bodies.brick.shape.rounding: must be at most half the least size"), std::string::npos);
}

// Both ends are whole numbers of steps, and what lies between is not.
TEST(CheckVariation, RefusesWhatLiesBetweenTheEnds) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: @\"loss.task[3].when.every\", distribution: uniform, lower: 10 ms, upper: 20 ms}\n", &place);
  EXPECT_TRUE(errors.starts_with(place + "variation[0].key: value 'loss.task[3].when.every': this can be drawn and "
                                         "is not allowed: loss.task[3].when.every = 0.0138"))
      << errors;
}

// Each alone stays on its side of the other's value in the file; together they cross.
TEST(CheckVariation, RefusesACorner) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: \"bodies.hinge.joint.limits.lower\", distribution: uniform, lower: -90 deg, upper: @60 deg}\n"
      "  - {key: \"bodies.hinge.joint.limits.upper\", distribution: uniform, lower: 30 deg, upper: 90 deg}\n",
      &place);
  EXPECT_EQ(errors, place +
                        "variation[0].upper: value '60 deg': this can be drawn and is not allowed: "
                        "bodies.hinge.joint.limits.lower = 1.0471975511965976 rad, bodies.hinge.joint.limits.upper = "
                        "0.5235987755982988 rad: bodies.hinge.joint.limits.lower: must be less than upper, "
                        "0.5235987755982988 rad\n");
}

TEST(CheckVariation, RefusesDrawsThatOverflow) {
  std::string place;
  const std::string errors = ParseWithVariations(
      "  - {key: @\"bodies.pea.initial.position[0]\", distribution: uniform, lower: -1e308 m, upper: 1.2e308 m}\n",
      &place);
  EXPECT_TRUE(errors.starts_with(place + "variation[0].key: ") && errors.ends_with("must be finite\n")) << errors;
}

TEST(CheckVariation, AllowsWhatFits) {
  std::string place;
  EXPECT_EQ(ParseWithVariations(
                "  - {key: \"bodies.brick.shape.size[1]\", distribution: uniform, lower: 3 mm, upper: 12 mm}\n"
                "  - {key: \"bodies.brick.shape.rounding\", distribution: uniform, lower: 0.1 mm, upper: 1.5 mm}\n"
                "  - {key: \"bodies.hinge.joint.axis[0]\", distribution: uniform, lower: -1, upper: 1}\n",
                &place),
            "");
}

}  // namespace
}  // namespace knap
