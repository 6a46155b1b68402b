// What --resume continues and what it refuses, and whom a run refuses as worker: the programs from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/short_runs.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace resume_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ResumeTest : public ::testing::Test {
 protected:
  struct Ended {
    int code;
    std::string err;
  };

  Ended Run(const std::string& program, std::vector<std::string> arguments) {
    ChildProcess knap(program, std::move(arguments), folder_ / "", "log");
    const int code = knap.Wait();
    return {code, knap.ReadErr()};
  }

  Ended Learn(const std::vector<std::string>& more, const std::string& program = KNAP_PROGRAM) {
    return Run(program, MakeShortRun("learn", "run", more));
  }

  void WriteJournal(const std::string& bytes) {
    std::ofstream(folder_ / "run/journal", std::ios::binary | std::ios::trunc) << bytes;
  }

  // Both programs in a folder of their own, knap-worker as if it had been built from other sources.
  std::string MakeOtherBuild() {
    const fs::path programs = folder_ / "programs";
    fs::create_directories(programs);
    fs::copy_file(KNAP_PROGRAM, programs / "knap");
    fs::copy_file(fs::path(KNAP_PROGRAM).parent_path() / "knap-worker", programs / "knap-worker");
    std::ofstream(programs / "knap-worker", std::ios::binary | std::ios::app) << "more";  // the loader does not mind
    return programs;
  }

  TemporaryFolder folder_;
};

TEST_F(ResumeTest, DamagedJournalsAreRefusedAndTornOnesContinued) {
  ASSERT_EQ(Learn({"--workers", "2"}).code, 0);
  const auto read_theta = [&] { return nlohmann::json::parse(ReadText(folder_ / "run/result.json"))["theta"]; };
  const nlohmann::json theta = read_theta();
  const std::string journal = ReadText(folder_ / "run/journal");

  std::string damaged = journal;
  damaged[journal.size() / 2] = static_cast<char>(damaged[journal.size() / 2] ^ 1);
  WriteJournal(damaged);
  const Ended refused = Run(KNAP_PROGRAM, {"learn", "--resume", "run"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("run/journal"), HasSubstr("corrupted"), HasSubstr("valid records follow")));
  EXPECT_EQ(ReadText(folder_ / "run/journal"), damaged);  // evidence is not touched

  fs::remove(folder_ / "run/result.json");
  WriteJournal(journal.substr(0, journal.size() * 2 / 3));
  EXPECT_EQ(Run(KNAP_PROGRAM, {"learn", "--resume", "run", "--workers", "1"}).code, 0);
  EXPECT_EQ(read_theta(), theta);
}

// The first row of rollouts.csv: id and loss.
std::pair<std::string, double> ReadFirstRow(const fs::path& path) {
  std::istringstream lines(ReadText(path));
  std::string names, row;
  std::getline(lines, names);
  std::getline(lines, row);
  std::istringstream name_fields(names), fields(row);
  std::string id, loss;
  for (std::string name, field; std::getline(name_fields, name, ',') && std::getline(fields, field, ',');) {
    if (name == "id") id = field;
    if (name == "loss") loss = field;
  }
  return {id, std::stod(loss)};
}

TEST_F(ResumeTest, AnyRequestOfARunCanBeComputedAlone) {
  ASSERT_EQ(Learn({"--workers", "2"}).code, 0);
  const auto [id, loss] = ReadFirstRow(folder_ / "run/rollouts.csv");
  ASSERT_EQ(id.size(), 64u);
  const auto compute = [&, id = id](const std::string& request) {
    ChildProcess knap(KNAP_PROGRAM, {"rollout", "run", "--json", "--request", request}, folder_ / "", "rollout");
    EXPECT_EQ(knap.Wait(), 0) << knap.ReadErr();
    return nlohmann::json::parse(knap.ReadOut())["loss"].get<double>();
  };
  EXPECT_EQ(compute(id), loss);
  // One that killed its workers has no answer in the journal: here, none of the first batch has.
  WriteJournal(ReadText(folder_ / "run/journal").substr(0, 400));
  EXPECT_EQ(compute(id.substr(0, 12)), loss);
  const Ended unknown = Run(KNAP_PROGRAM, {"rollout", "run", "--request", "0123456789ab"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("0123456789ab"));
}

TEST_F(ResumeTest, AnotherBuildIsNotContinued) {
  ASSERT_EQ(Learn({"--workers", "1"}).code, 0);
  const Ended refused = Run(MakeOtherBuild() + "/knap", {"learn", "--resume", "run"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("run/journal"), HasSubstr("another build of knap-worker")));
}

TEST_F(ResumeTest, WorkersOfAnotherBuildGetNoWork) {
  const std::string url = MakeOwnLcmUrl();
  const SteadyClock clock;
  LcmTransport listener(url, {std::string(kWorkerStatusChannel)}, &clock);
  ChildProcess worker(MakeOtherBuild() + "/knap-worker", {"--lcm-url", url, "--name", "stale"}, folder_ / "", "worker");
  // From its first word on it speaks four times a second; within --wait one of them will be heard.
  ASSERT_TRUE(WaitFor([&] { return listener.Receive(0).has_value() || worker.HasEnded(); }));
  ASSERT_FALSE(worker.HasEnded()) << worker.ReadErr();
  const Ended ended = Learn({"--external", "--wait", "10", "--lcm-url", url});
  EXPECT_EQ(ended.code, 4);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("refused worker stale on "), HasSubstr("build")));
}

}  // namespace resume_test
}  // namespace knap
