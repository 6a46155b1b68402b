#include "sim/scenarios/scenario_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "sim/scenarios/dump_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace scenario_files_test {

namespace fs = std::filesystem;

class ScenarioFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / ("knap_scenario_files_" + std::to_string(getpid()) + info->name());
    fs::create_directories(folder_ / "meshes");
    Write("scene.yaml", kEverythingYaml);
    Write("meshes/tool.obj", std::string("mesh \0\r\n\xff bytes", 14));
    Write("meshes/tool_cage.obj", "");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  LoadedScenario Load(const std::vector<std::string>& overrides = {}) {
    return LoadScenario(folder_ / "scene.yaml", overrides);
  }

  fs::path folder_;
};

TEST_F(ScenarioFilesTest, CarryTheSceneAndItsMeshesWithoutTheDisk) {
  const LoadedScenario loaded = Load({"learning.batch=3"});
  ASSERT_TRUE(loaded.parsed.ok()) << loaded.parsed.FormatErrors();
  ASSERT_EQ(loaded.files.size(), 3u);
  EXPECT_EQ(loaded.files.at("meshes/tool.obj"), std::string("mesh \0\r\n\xff bytes", 14));
  EXPECT_EQ(loaded.files.at("meshes/tool_cage.obj"), "");
  fs::remove_all(folder_);
  const Scene scene = ParseScenarioFiles(loaded.files);
  EXPECT_EQ(scene.learning.batch, 3);
  EXPECT_EQ(DumpScene(scene), DumpScene(loaded.parsed.scene));
}

// Seeds and methods of one task share its rollouts; another world or another wish is another task.
TEST_F(ScenarioFilesTest, ATaskSaysNothingOfHowItIsLearned) {
  const std::map<std::string, std::string> task = ListTaskFiles(Load());
  EXPECT_EQ(task.size(), 3u);
  for (const char* how : {"learning.seed=987", "learning.alpha=0.37", "evaluation.seed=987"}) {
    EXPECT_EQ(ListTaskFiles(Load({how})), task) << how;
    EXPECT_NE(Load({how}).files, Load().files) << how;
  }
  for (const char* what : {"gravity[2]=-9 m/s^2", "loss.task[0].weight=3", "trust.penetration=0.4"}) {
    EXPECT_NE(ListTaskFiles(Load({what})), task) << what;
  }
  EXPECT_EQ(DumpTask(ParseScenarioFiles(task)), task.at("scenario.yaml"));
}

TEST_F(ScenarioFilesTest, MissingFilesAreErrorsOfTheConfig) {
  fs::remove(folder_ / "meshes/tool.obj");
  fs::remove(folder_ / "meshes/tool_cage.obj");
  fs::create_directory(folder_ / "meshes/tool_cage.obj");
  const LoadedScenario loaded = Load({"learning.batch=x"});
  const std::string file = (folder_ / "scene.yaml").string();
  const std::string meshes = (folder_ / "meshes").string();
  EXPECT_EQ(loaded.parsed.FormatErrors(),
            file + ":133:13: design.bodies.tool.mesh: value 'meshes/tool.obj': the file " + meshes +
                "/tool.obj cannot be read: No such file or directory\n" + file +
                ":134:13: design.bodies.tool.cage: value 'meshes/tool_cage.obj': the file " + meshes +
                "/tool_cage.obj cannot be read: not a regular file\n"
                "command line: learning.batch=x: learning.batch: value 'x': expected an integer, from 1 to 1e+06\n");
  EXPECT_TRUE(loaded.files.empty());
}

TEST_F(ScenarioFilesTest, ALibraryAboveIsShared) {
  fs::create_directories(folder_ / "tasks/deep/robots");
  fs::create_directories(folder_ / "library/rings");
  Write("library/rings/ring.obj", "ring");
  const auto find = [&](const std::string& path) { return FindScenarioFile(folder_ / "tasks/deep", path); };
  EXPECT_EQ(find("library/rings/ring.obj"), folder_ / "library/rings/ring.obj");
  EXPECT_EQ(find("robots/library/rings/ring.obj"), folder_ / "library/rings/ring.obj") << "of an included file";
  EXPECT_EQ(find("library/none.obj"), folder_ / "tasks/deep/library/none.obj") << "what a message shows";
  EXPECT_EQ(find("rings/ring.obj"), folder_ / "tasks/deep/rings/ring.obj");
  fs::create_directories(folder_ / "tasks/library/rings");
  Write("tasks/library/rings/ring.obj", "nearer");
  EXPECT_EQ(find("library/rings/ring.obj"), folder_ / "tasks/library/rings/ring.obj");

  std::string text = kEverythingYaml;
  text.replace(text.find("meshes/tool.obj"), 15, "library/t.obj");
  Write("tasks/scene.yaml", text);
  fs::create_directories(folder_ / "tasks/meshes");
  Write("tasks/meshes/tool_cage.obj", "");
  Write("library/t.obj", "shared");
  const LoadedScenario loaded = LoadScenario(folder_ / "tasks/scene.yaml");
  ASSERT_TRUE(loaded.parsed.ok()) << loaded.parsed.FormatErrors();
  EXPECT_EQ(loaded.files.at("library/t.obj"), "shared");
}

TEST_F(ScenarioFilesTest, AMissingScenarioIsAnError) {
  const LoadedScenario loaded = LoadScenario(folder_ / "none.yaml");
  EXPECT_EQ(loaded.parsed.FormatErrors(),
            (folder_ / "none.yaml").string() + ":1:1: cannot be read: No such file or directory\n");
}

TEST_F(ScenarioFilesTest, RefuseWhatIsNotExactlyAScenario) {
  const std::map<std::string, std::string> files = Load().files;
  const auto expect_error = [](const std::map<std::string, std::string>& changed, const std::string& message) {
    try {
      ParseScenarioFiles(changed);
      ADD_FAILURE() << "accepted; expected: " << message;
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(e.what(), message);
    }
  };
  std::map<std::string, std::string> changed = files;
  changed.erase(kScenarioFileName);
  expect_error(changed, "the scenario has no scenario.yaml");
  changed = files;
  changed.erase("meshes/tool.obj");
  expect_error(changed, "the scenario lacks the file 'meshes/tool.obj' that its design.bodies.tool.mesh names");
  changed = files;
  changed["../evil"] = "x";
  expect_error(changed, "the scenario carries a file '../evil' that it does not name");
  changed = files;
  changed[kScenarioFileName] += "oops: 1\n";
  EXPECT_THROW(ParseScenarioFiles(changed), std::runtime_error);
}

TEST(IsScenarioFilePath, StaysInTheFolder) {
  for (const char* path : {"tool.obj", "meshes/tool.obj", "a/b/c", "..x", "a..b/c.."}) {
    EXPECT_TRUE(IsScenarioFilePath(path)) << path;
  }
  for (const char* path : {"", "/", "/etc/passwd", "..", "../x", "a/../b", "a/..", "./a", "a//b", "a/", "a\\b", "C:x",
                           "a\nb", "scenario.yaml"}) {
    EXPECT_FALSE(IsScenarioFilePath(path)) << path;
  }
  EXPECT_FALSE(IsScenarioFilePath(std::string(300, 'a')));
}

}  // namespace scenario_files_test
}  // namespace knap
