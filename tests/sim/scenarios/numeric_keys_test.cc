#include "sim/scenarios/numeric_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace numeric_keys_test {

Scene ParseEverything() {
  ParseResult result = ParseScene(kEverythingYaml, "f.yaml");
  EXPECT_TRUE(result.ok()) << result.FormatErrors();
  return result.scene;
}

TEST(FindNumericKeys, PointsIntoTheSceneThatWasAsked) {
  const Scene scene = ParseEverything();
  Scene copy = scene;
  const std::vector<std::string> paths{"bodies.pea.initial.position[1]",     "gravity[2]",
                                       "bodies.tool.joint.motion.amplitude", "loss.task[0].when.at",
                                       "design.parameters.width.upper",      "bodies.pea.shapes[0].radius"};
  const std::vector<double*> numbers = FindNumericKeys(copy, paths);
  ASSERT_EQ(numbers.size(), paths.size());
  EXPECT_EQ(*numbers[0], 0.1);
  EXPECT_EQ(*numbers[1], -1.62);
  EXPECT_EQ(*numbers[2], 0.06);
  EXPECT_EQ(*numbers[3], 0.37);
  EXPECT_EQ(*numbers[4], 0.056);
  EXPECT_EQ(*numbers[5], 0.01);
  *numbers[0] = 7.0;
  EXPECT_EQ(std::get<FreeJoint>(copy.bodies.back().joint.kind).initial.position.y(), 7.0);
  EXPECT_EQ(std::get<FreeJoint>(scene.bodies.back().joint.kind).initial.position.y(), 0.1);
}

TEST(FindNumericKeys, NamesThePathThatDoesNotExist) {
  Scene scene = ParseEverything();
  const std::vector<std::string> paths{"gravity[3]"};
  try {
    FindNumericKeys(scene, paths);
    FAIL() << "found gravity[3]";
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "the scene has no number 'gravity[3]'");
  }
}

TEST(ListNumericKeys, PathsAndNumbersAreDistinct) {
  Scene scene = ParseEverything();
  const std::vector<NumericKey> keys = ListNumericKeys(scene);
  EXPECT_GT(keys.size(), 100u);
  std::set<std::string> paths;
  std::set<const double*> values;
  for (const NumericKey& key : keys) {
    paths.insert(key.path);
    values.insert(key.value);
    EXPECT_TRUE(key.range.Contains(*key.value)) << key.path;
  }
  EXPECT_EQ(paths.size(), keys.size());
  EXPECT_EQ(values.size(), keys.size());
}

bool PathMayVary(const std::string& path) {
  NumericKey key;
  key.path = path;
  return MayVary(key);
}

TEST(MayVary, ExcludesTheMachinery) {
  EXPECT_TRUE(PathMayVary("gravity[2]"));
  EXPECT_TRUE(PathMayVary("bodies.pea.shapes[0].radius"));
  EXPECT_TRUE(PathMayVary("success.of[0].when.at"));
  EXPECT_TRUE(PathMayVary("signals.pill_error.targets[0].position[1]"));
  EXPECT_FALSE(PathMayVary("rollout.step"));
  EXPECT_FALSE(PathMayVary("learning.alpha"));
  EXPECT_FALSE(PathMayVary("design.parameters.width.initial"));
  EXPECT_FALSE(PathMayVary("variation[0].lower"));
}

}  // namespace numeric_keys_test
}  // namespace knap
