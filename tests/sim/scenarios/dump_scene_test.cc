#include "sim/scenarios/dump_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace dump_scene_test {

TEST(DumpScene, IsAFixedPointOfReading) {
  for (const char* yaml : {kPendulumYaml, kEverythingYaml}) {
    const ParseResult first = ParseScene(yaml, "first.yaml");
    ASSERT_TRUE(first.ok()) << first.FormatErrors();
    const std::string text = DumpScene(first.scene);
    const ParseResult second = ParseScene(text, "second.yaml");
    ASSERT_TRUE(second.ok()) << second.FormatErrors() << text;
    EXPECT_EQ(DumpScene(second.scene), text);
    EXPECT_EQ(second.scene.description, first.scene.description);
    EXPECT_EQ(second.scene.learning.seed, first.scene.learning.seed);
    EXPECT_EQ(second.scene.bodies.size(), first.scene.bodies.size());
  }
}

TEST(DumpScene, WritesDefaultsAndSiUnits) {
  const std::string text = DumpScene(ParseScene(kPendulumYaml, "f.yaml").scene);
  EXPECT_THAT(text, testing::HasSubstr("gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]\n"));
  EXPECT_THAT(text, testing::HasSubstr("contacts: []\n"));
  EXPECT_THAT(text, testing::HasSubstr("      axis: [0, 1, 0]\n      damping: 0.1 N*m*s/rad\n"));
  EXPECT_THAT(text, testing::HasSubstr("decay: 0.36787944117144233\n"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("design:")));
}

// Bodies' initial positions take any finite number, so any bits will do there.
RC_GTEST_PROP(DumpScene, KeepsEveryBit, (std::uint64_t a, std::uint64_t b, std::uint64_t c)) {
  Scene scene = ParseScene(kEverythingYaml, "f.yaml").scene;
  const std::vector<std::uint64_t> bits{a, b, c};
  const std::vector<std::string> paths{"bodies.pea.initial.position[0]", "bodies.hinge.initial.angle", "gravity[1]"};
  const std::vector<double*> numbers = FindNumericKeys(scene, paths);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    RC_PRE(std::isfinite(std::bit_cast<double>(bits[i])));
    *numbers[i] = std::bit_cast<double>(bits[i]);
  }
  ParseResult read = ParseScene(DumpScene(scene), "f.yaml");
  RC_ASSERT(read.FormatErrors().empty());
  const std::vector<NumericKey> before = ListNumericKeys(scene);
  const std::vector<NumericKey> after = ListNumericKeys(read.scene);
  RC_ASSERT(before.size() == after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    RC_ASSERT(before[i].path == after[i].path);
    RC_ASSERT(std::bit_cast<std::uint64_t>(*before[i].value) == std::bit_cast<std::uint64_t>(*after[i].value));
  }
}

// Any text of a YAML stream's characters, as people write descriptions.
RC_GTEST_PROP(DumpScene, KeepsAnyDescription, ()) {
  Scene scene = ParseScene(kPendulumYaml, "f.yaml").scene;
  scene.description = *rc::gen::container<std::string>(rc::gen::inRange<char>(1, 127));
  ParseResult read = ParseScene(DumpScene(scene), "f.yaml");
  RC_ASSERT(read.FormatErrors().empty());
  RC_ASSERT(read.scene.description == scene.description);
}

}  // namespace dump_scene_test
}  // namespace knap
