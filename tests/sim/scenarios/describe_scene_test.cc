#include "sim/scenarios/describe_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace describe_scene_test {

using testing::HasSubstr;

TEST(DescribeSceneFormat, TellsUnitsRangesAndDefaults) {
  const std::string text = DescribeSceneFormat();
  EXPECT_THAT(text, HasSubstr("## `bodies[].shapes[]`: type sphere\n"));
  EXPECT_THAT(text, HasSubstr("| `radius` | number in m, more than 0 m | required | of the sphere |"));
  EXPECT_THAT(
      text, HasSubstr("| `batch` | integer, from 1 to 1e+06 | 5 | M: variations in a batch; 1 where nothing varies |"));
  EXPECT_THAT(text, HasSubstr("| `gravity` | list of 3: number in m/s^2 | [0 m/s^2, 0 m/s^2, -9.81 m/s^2] |"));
  EXPECT_THAT(text, HasSubstr("## `bodies[].initial`: state of a ball joint at time 0\n"));
  EXPECT_THAT(text, HasSubstr("| **half_space** | – | yes | yes | yes | yes | yes | yes |"));
  EXPECT_THAT(text, HasSubstr("| `integrator` | one of tr_bdf2, bdf1, bdf2 | tr_bdf2 |"));
}

// docs/scenario.md is what `knap validate --describe` prints.
TEST(DescribeSceneFormat, IsTheCommittedPage) {
  std::ifstream file(KNAP_DOCS "/scenario.md");
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_EQ(page.str(), DescribeSceneFormat()) << "write it anew: knap validate --describe > docs/scenario.md";
}

// Whatever a file can hold is described: every key of the fullest sample appears in some table.
TEST(DescribeSceneFormat, KnowsEveryKey) {
  const std::string text = DescribeSceneFormat();
  const std::string dump = DumpScene(ParseScene(kEverythingYaml, "f.yaml").scene);
  int keys = 0;
  for (std::size_t line = 0; line < dump.size(); line = dump.find('\n', line) + 1) {
    const std::size_t key = dump.find_first_not_of(" -", line);
    EXPECT_THAT(text, HasSubstr("| `" + dump.substr(key, dump.find(':', key) - key) + "` |"));
    ++keys;
  }
  EXPECT_GT(keys, 150);
}

}  // namespace describe_scene_test
}  // namespace knap
