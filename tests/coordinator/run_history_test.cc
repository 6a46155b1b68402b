#include "coordinator/report/run_history.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "coordinator/run_directory/run_directory.h"
#include "coordinator/run_directory/run_logs.h"
#include "coordinator/run_directory/temporary_folder.h"

namespace knap {
namespace run_history_test {

using Json = nlohmann::ordered_json;

void Write(const std::filesystem::path& path, const std::string& text, std::ios::openmode mode = std::ios::app) {
  std::ofstream(path, std::ios::binary | mode) << text;
}

// A folder that passes for a run's, with logs that have nothing but their headers.
RunDirectory MakeRun(const TemporaryFolder& folder) {
  Write(folder / "config.yaml", "");
  const RunDirectory run = RunDirectory::Open(folder.path());
  MetricsLog(run.metrics_path(), {"width"});
  RolloutLog(run.rollouts_path());
  EventLog(run.events_path());
  return run;
}

RolloutRow MakeRow(int number) {
  RolloutRow row;
  row.time_s = 0.1 * number;
  row.id = std::to_string(number);
  row.kind = number % 3 == 0 ? "validation" : "task";
  row.worker = number % 2 == 0 ? "one" : "two";
  row.attempt = 1 + number % 2;
  row.gradient_reliable = number % 5 != 0;
  row.converged = true;
  row.distrust = number % 7 == 0 ? "a and b press into one another, 61%" : "";
  row.penetration = 0.01 * number;
  row.forward_s = 0.02;
  return row;
}

void AppendEvaluation(MetricsLog* log, int number) {
  LearningEvaluation evaluation{.batch = 1, .evaluation = number, .best_loss = 1.0 / (1 + number), .rollouts = number};
  evaluation.value.theta = {0.1 * number};
  evaluation.value.accepted = true;
  evaluation.value.loss = evaluation.best_loss;
  log->Append(0.1 * number, evaluation);
}

std::string Describe(const RunHistory& history) {
  return history.MakeLearningJson().dump() + history.MakeTimelineJson().dump() + history.MakeCertificatesJson().dump();
}

std::string DescribeAtOnce(const RunDirectory& run) {
  RunHistory history(run);
  history.Read();
  return Describe(history);
}

TEST(RunHistoryTest, PieceByPieceIsAsAtOnceWhereverAPieceEnds) {
  const TemporaryFolder all_folder;
  const RunDirectory all = MakeRun(all_folder);
  {
    MetricsLog metrics(all.metrics_path(), {"width"});
    RolloutLog rollouts(all.rollouts_path());
    EventLog events(all.events_path());
    events.Append(0.0, "begin", {{"run_id", "01"}});
    for (int i = 0; i < 20; ++i) {
      if (i % 5 == 0) events.Append(0.1 * i, "batch_start", {{"batch", 1 + i / 5}, {"variations", {1, 2, 3}}});
      AppendEvaluation(&metrics, i);
      for (int k = 0; k < 3; ++k) rollouts.Append(MakeRow(3 * i + k));
      if (i % 5 == 4) events.Append(0.1 * i, "batch_end", {{"batch", 1 + i / 5}, {"theta", {0.1}}, {"stop", "steps"}});
    }
    events.Append(3.0, "workers_lost", {{"count", 1}});
  }
  const TemporaryFolder folder;
  Write(folder / "config.yaml", "");
  const RunDirectory run = RunDirectory::Open(folder.path());
  std::vector<std::pair<std::string, std::filesystem::path>> files;
  for (const auto& [from, to] :
       {std::pair(all.metrics_path(), run.metrics_path()), std::pair(all.rollouts_path(), run.rollouts_path()),
        std::pair(all.events_path(), run.events_path())}) {
    std::ifstream file(from, std::ios::binary);
    files.emplace_back(std::string(std::istreambuf_iterator<char>(file), {}), to);
    Write(to, "");
  }
  RunHistory history(run);
  std::mt19937 random(7);
  for (bool more = true; more;) {
    more = false;
    for (auto& [rest, path] : files) {
      const std::size_t length = std::min<std::size_t>(rest.size(), random() % 200);
      Write(path, rest.substr(0, length));
      rest.erase(0, length);
      more = more || !rest.empty();
    }
    history.Read();
  }
  EXPECT_EQ(Describe(history), DescribeAtOnce(all));
  EXPECT_EQ(history.MakeTimelineJson()["rollouts"]["end_s"].size(), 60u);
  const Json certificates = history.MakeCertificatesJson();
  EXPECT_EQ(certificates["gradients"], 40);
  EXPECT_EQ(certificates["gradients_flagged"], 8);
  EXPECT_EQ(certificates["untrusted"], 9);
  EXPECT_DOUBLE_EQ(certificates["deepest"].get<double>(), 0.59);
}

// A resumed run repeats its evaluations from the journal, sooner or later as many lines as before.
TEST(RunHistoryTest, AResumedRunsMetricsTakeThePlaceOfThoseBefore) {
  for (const int repeated : {0, 2, 5, 8}) {
    const TemporaryFolder folder;
    const RunDirectory run = MakeRun(folder);
    EventLog events(run.events_path());
    RunHistory history(run);
    {
      MetricsLog metrics(run.metrics_path(), {"width"});
      events.Append(0.0, "begin", {{"run_id", "01"}});
      for (int i = 0; i < 5; ++i) AppendEvaluation(&metrics, i);
    }
    history.Read();
    ASSERT_EQ(history.MakeLearningJson()["evaluations"]["loss"].size(), 5u);
    MetricsLog metrics(run.metrics_path(), {"width"});
    events.Append(1.0, "begin", {{"run_id", "02"}});
    for (int i = 0; i < repeated; ++i) AppendEvaluation(&metrics, i);
    history.Read();
    EXPECT_EQ(history.MakeLearningJson()["evaluations"]["loss"].size(), static_cast<std::size_t>(repeated));
    EXPECT_EQ(Describe(history), DescribeAtOnce(run));
    AppendEvaluation(&metrics, repeated);
    history.Read();
    EXPECT_EQ(Describe(history), DescribeAtOnce(run));
  }
}

TEST(RunHistoryTest, AMissingFileIsNamed) {
  const TemporaryFolder folder;
  const RunDirectory run = MakeRun(folder);
  std::filesystem::remove(run.rollouts_path());
  RunHistory history(run);
  try {
    history.Read();
    FAIL() << "read without rollouts.csv";
  } catch (const std::system_error& e) {
    EXPECT_NE(std::string(e.what()).find("rollouts.csv"), std::string::npos) << e.what();
  }
}

}  // namespace run_history_test
}  // namespace knap
