// A design within its bounds that turns the tool inside out, met by the programs: a rejected evaluation, no dead run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "sim/geometry/mesh_io.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"

namespace knap {
namespace folded_design_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const std::string kConfig = KNAP_TEST_DATA "/mesh/turned_over.yaml";

class FoldedDesignTest : public ::testing::Test {
 protected:
  Ended Run(std::vector<std::string> arguments) {
    return RunToEnd(KNAP_PROGRAM, std::move(arguments), folder_ / "", "log");
  }

  TemporaryFolder folder_;
};

TEST_F(FoldedDesignTest, IsARejectedEvaluationAndTheRunLives) {
  const Ended learned = Run({"learn", kConfig, "--workers", "1", "--out", "run"});
  ASSERT_EQ(learned.code, 0) << learned.err;
  // The learner went there, and it did not count.
  EXPECT_THAT(ReadCsv(folder_ / "run/metrics.csv")["accepted"], AllOf(Contains("0"), Contains("1")));
  std::ifstream file(folder_ / "run/tool/learned.stl", std::ios::binary);
  const std::string stl{std::istreambuf_iterator<char>(file), {}};
  const TriangleMesh tool = ReadMesh("learned.stl", stl, 1.0);
  EXPECT_EQ(FindDefects(tool).Describe(), "");
  EXPECT_GT(CalcSignedVolume(tool), 0.0);

  fs::create_directory(folder_ / "again");
  fs::copy(folder_ / "run", folder_ / "again", fs::copy_options::recursive);
  fs::remove(folder_ / "again/result.json");
  const Ended resumed = Run({"learn", "--resume", "again", "--workers", "1"});
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  ExpectSameRun(folder_ / "again", folder_ / "run");
}

TEST_F(FoldedDesignTest, ValidateWarnsOfItAndRolloutNamesIt) {
  const Ended valid = Run({"validate", kConfig});
  EXPECT_EQ(valid.code, 0);
  EXPECT_THAT(valid.err,
              AllOf(HasSubstr("warning: 2 of the 4 designs"), HasSubstr("width -30 mm"), HasSubstr("inside out")));
  EXPECT_EQ(Run({"validate", kConfig, "design.parameters.width.lower=20 mm"}).err, "");

  const Ended rollout =
      Run({"rollout", kConfig, "design.parameters.width.initial=24 mm", "--theta", "-0.03", "--json"});
  ASSERT_EQ(rollout.code, 0) << rollout.err;
  const auto json = nlohmann::json::parse(rollout.out);
  EXPECT_FALSE(json["certificate"]["finite"]);
  EXPECT_THAT(json["certificate"]["failure"].get<std::string>(), HasSubstr("inside out"));
}

}  // namespace folded_design_test
}  // namespace knap
