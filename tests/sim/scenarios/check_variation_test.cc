// Draws are tried before a rollout: alone at both ends and between, together at the corners.
#include "sim/scenarios/check_variation.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/sim/scenarios/edited_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace check_variation_test {

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
      "  - {key: \"bodies.brick.shapes[0].size[1]\", distribution: normal, mean: 8 mm, std: @2.2 mm}\n", &place);
  EXPECT_TRUE(errors.starts_with(place + "variation[0].std: value '2.2 mm': this can be drawn and is not allowed: "
                                         "bodies.brick.shapes[0].size[1] = 0.00"))
      << errors;
  EXPECT_NE(errors.find("bodies.brick.shapes[0].rounding: must be at most half the least size"), std::string::npos);
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
                "  - {key: \"bodies.brick.shapes[0].size[1]\", distribution: uniform, lower: 3 mm, upper: 12 mm}\n"
                "  - {key: \"bodies.brick.shapes[0].rounding\", distribution: uniform, lower: 0.1 mm, upper: 1.5 mm}\n"
                "  - {key: \"bodies.hinge.joint.axis[0]\", distribution: uniform, lower: -1, upper: 1}\n",
                &place),
            "");
}

// One line of each distribution of several numbers, allowed and refused.
struct Kind {
  const char* name;
  const char* entry;    // with an @ where the error stands
  const char* message;  // empty: allowed
};

class Kinds : public testing::TestWithParam<Kind> {};

TEST_P(Kinds, AreCheckedLikeUniformOnes) {
  std::string place;
  const std::string errors = ParseWithVariations(std::string("  - {") + GetParam().entry + "}\n", &place);
  if (std::string(GetParam().message).empty()) {
    EXPECT_EQ(errors, "");
  } else {
    EXPECT_TRUE(errors.starts_with(place) && errors.find(GetParam().message) != std::string::npos) << errors;
  }
}

#define POSITION "bodies.pea.initial.position"
INSTANTIATE_TEST_SUITE_P(
    All, Kinds,
    testing::Values(
        Kind{"LogUniform", "distribution: log_uniform, key: \"contacts[1].friction\", lower: 0.01, upper: 1", ""},
        Kind{"LogUniformOrder", "distribution: log_uniform, key: \"contacts[1].friction\", lower: @1, upper: 0.5",
             "must be at most upper, 0.5"},
        Kind{"LogUniformZero", "distribution: log_uniform, key: \"contacts[1].friction\", lower: @0, upper: 1",
             "must be more than 0"},
        Kind{"Choice", "distribution: choice, key: \"contacts[1].friction\", values: [0.1, 0.4]", ""},
        Kind{"ChoiceRange", "distribution: choice, key: \"contacts[1].friction\", values: @[0.1, -0.4]",
             "draws reach from -0.4 to 0.1, but the key must be from 0 to 10"},
        Kind{"ChoiceUnit", "distribution: choice, key: \"contacts[1].friction\", values: [@1 mm]",
             "expected a number without a unit"},
        Kind{"Disc",
             "distribution: disc, keys: [\"" POSITION "[0]\", \"" POSITION
             "[1]\"], center: [0 mm, 80 mm], radius: 10 mm",
             ""},
        Kind{"DiscKeys", "distribution: disc, keys: @[\"" POSITION "[0]\"], center: [0 mm, 80 mm], radius: 10 mm",
             "expected exactly 2 elements"},
        Kind{"DiscUnits",
             "distribution: disc, keys: [\"" POSITION
             "[0]\", @\"contacts[0].friction\"], center: [0 mm, 80 mm], radius: 10 mm",
             "must have the unit of the first key"},
        Kind{"Ball",
             "distribution: ball, keys: [\"" POSITION "[0]\", \"" POSITION "[1]\", \"" POSITION
             "[2]\"], center: [0 mm, 80 mm, 9 mm], radius: 1 mm",
             ""},
        Kind{"Orientation",
             "distribution: orientation, keys: [\"bodies.pea.initial.orientation_rpy[0]\", "
             "\"bodies.pea.initial.orientation_rpy[1]\", \"bodies.pea.initial.orientation_rpy[2]\"]",
             ""},
        Kind{"OrientationOfLengths",
             "distribution: orientation, keys: [@\"" POSITION "[0]\", \"" POSITION "[1]\", \"" POSITION "[2]\"]",
             "must be the angles of an orientation"},
        Kind{"Turn",
             "distribution: turn, keys: [\"bodies.pea.initial.orientation_rpy[0]\", "
             "\"bodies.pea.initial.orientation_rpy[1]\", \"bodies.pea.initial.orientation_rpy[2]\"], "
             "axis: [0, 1, 1], lower: -90 deg, upper: 90 deg",
             ""},
        Kind{"TurnWithoutAxis",
             "distribution: turn, keys: [\"bodies.pea.initial.orientation_rpy[0]\", "
             "\"bodies.pea.initial.orientation_rpy[1]\", "
             "\"bodies.pea.initial.orientation_rpy[2]\"], "
             "axis: @[0, 0, 0], lower: -90 deg, upper: 90 deg",
             "must not be zero"},
        Kind{"Correlated",
             "distribution: correlated, keys: [\"" POSITION "[0]\", \"" POSITION
             "[1]\"], mean: [0 mm, 80 mm], std: [5 mm, 5 mm], correlation: [0.5]",
             ""},
        Kind{"CorrelatedCount",
             "distribution: correlated, keys: [\"" POSITION "[0]\", \"" POSITION
             "[1]\"], mean: @[0 mm], std: [5 mm, 5 mm], correlation: [0.5]",
             "has 1 numbers; 2 are needed for 2 keys"},
        Kind{"CorrelatedImpossible",
             "distribution: correlated, keys: [\"" POSITION "[0]\", \"" POSITION "[1]\", \"" POSITION
             "[2]\"], mean: [0 mm, 80 mm, 9 mm], std: [1 mm, 1 mm, 1 mm], "
             "correlation: @[0.9, 0.9, -0.9]",
             "no numbers can have all these correlations"},
        Kind{"Twice",
             "distribution: disc, keys: [\"" POSITION "[0]\", @\"" POSITION
             "[0]\"], center: [0 mm, 80 mm], radius: 10 mm",
             "already varies, see variation[0]"}),
    [](const auto& the_case) { return std::string(the_case.param.name); });

}  // namespace check_variation_test
}  // namespace knap
