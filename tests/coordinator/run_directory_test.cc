#include "coordinator/run_directory/run_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/earlier_life.h"
#include "coordinator/run_directory/run_logs.h"
#include "coordinator/run_directory/temporary_folder.h"

namespace knap {
namespace run_directory_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::ordered_json;

// 2025-01-31 23:59:59 UTC.
const std::chrono::system_clock::time_point kStarted{std::chrono::seconds(1738367999)};

std::vector<std::string> ReadLines(const fs::path& path) {
  std::istringstream text(ReadFile(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

ResultDocument MakeDocument() {
  ResultDocument document;
  document.scenario = "pushing";
  document.method = "ours";
  document.seed = std::numeric_limits<std::uint64_t>::max();
  document.parameters = {{"width", "depth"}, {0.01, -0.02}, {0.12, 0.03}, {0.1, 0.0}};
  document.learned = {0.1 + 0.2, 1.0 / 3.0};
  document.test_initial = {.variations = 200, .seed = 77, .loss_mean = 2.5, .loss_std = 0.5, .success_rate = 0.14};
  document.test_learned = {.variations = 200, .seed = 77, .loss_mean = 0.1, .loss_std = 0.2, .success_rate = 0.98};
  document.rollouts_total = 2345;
  document.rollouts_distinct = 2300;
  document.rollouts_reissued = 7;
  document.wall_s = 61.25;
  return document;
}

LearningEvaluation MakeEvaluation(int number, double loss) {
  LearningEvaluation evaluation{.batch = 1, .evaluation = number, .best_loss = loss, .rollouts = 5 * (number + 1)};
  evaluation.value.theta = {0.1 + 0.2, -1e-300};
  evaluation.value.accepted = true;
  evaluation.value.loss = evaluation.value.task_loss = loss;
  return evaluation;
}

TEST(RunDirectoryTest, NamedRunsGetTheirTimeAndTheLinkLatest) {
  const TemporaryFolder folder;
  EXPECT_EQ(MakeRunName("pushing", kStarted), "pushing-20250131T235959Z");
  const RunDirectory first = RunDirectory::CreateNamed(folder / "runs", "pushing", kStarted);
  EXPECT_EQ(first.path().filename(), "pushing-20250131T235959Z");
  EXPECT_EQ(first.LinkLatest(), std::nullopt);
  EXPECT_TRUE(fs::equivalent(folder / "runs/latest", first.path()));
  const RunDirectory second = RunDirectory::CreateNamed(folder / "runs", "pushing", kStarted);
  EXPECT_EQ(second.path().filename(), "pushing-20250131T235959Z-2");
  EXPECT_EQ(second.LinkLatest(), std::nullopt);
  EXPECT_TRUE(fs::equivalent(folder / "runs/latest", second.path()));
  EXPECT_TRUE(fs::read_symlink(folder / "runs/latest").is_relative());  // runs/ can be moved
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "runs"), fs::directory_iterator()), 3);
}

// What somebody put there stays, and nothing of the attempt does.
TEST(RunDirectoryTest, WhatIsNoLinkIsNotReplacedByOne) {
  for (const bool is_folder : {true, false}) {
    const TemporaryFolder folder;
    const RunDirectory run = RunDirectory::CreateNamed(folder / "runs", "pushing", kStarted);
    if (is_folder) fs::create_directories(folder / "runs/latest");
    if (!is_folder) std::ofstream(folder / "runs/latest") << "mine";
    EXPECT_THAT(run.LinkLatest().value_or(""), HasSubstr("runs/latest"));
    EXPECT_EQ(fs::is_directory(folder / "runs/latest"), is_folder);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "runs"), fs::directory_iterator()), 2);
  }
}

TEST(RunDirectoryTest, ARemovedRunLeavesNoTrace) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  run.WriteConfig("scenario: pushing\n");
  run.Remove();
  EXPECT_FALSE(fs::exists(folder / "run"));
}

TEST(RunDirectoryTest, NeverTakesAFolderThatHoldsSomething) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "a/b");
  EXPECT_NO_THROW(RunDirectory::Create(folder / "a/b"));  // still empty
  run.WriteConfig("scenario: pushing\n");
  EXPECT_THROW(RunDirectory::Create(folder / "a/b"), std::runtime_error);
  EXPECT_THROW(RunDirectory::Create(run.config_path()), std::runtime_error);
  EXPECT_EQ(ReadFile(RunDirectory::Open(folder / "a/b").config_path()), "scenario: pushing\n");
  EXPECT_THROW(RunDirectory::Open(folder / "a"), std::runtime_error);
}

// Killed before the folder was a run, it does not stand in the way of the next try.
TEST(RunDirectoryTest, TakesTheBeginningThatACrashCutOff) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  run.WriteRunInfo({});
  EXPECT_NO_THROW(RunDirectory::Create(folder / "run"));
  run.WriteConfig("scenario: pushing\n");
  EXPECT_THROW(RunDirectory::Create(folder / "run"), std::runtime_error);
}

TEST(RunDirectoryTest, RunInfoIsWritten) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  run.WriteRunInfo(
      {"0.1.0", "abc", "pushing", "ours", 3, "host", "00ff", "runs/first", kStarted, {{"b", "1"}, {"a: of it", "2"}}});
  const Json json = Json::parse(ReadFile(run.path() / "run.json"));
  EXPECT_EQ(json["seed"], 3);
  EXPECT_EQ(json["started_utc"], "2025-01-31T23:59:59Z");
  EXPECT_EQ(json["config_hash"], "00ff");
  EXPECT_EQ(json["started_from"], "runs/first");
  EXPECT_EQ(run.ReadIdentity(), (RunIdentity{{"b", "1"}, {"a: of it", "2"}}));
  WriteFileAtomically(run.info_path(), "{}");
  EXPECT_THROW(run.ReadIdentity(), std::runtime_error);
}

TEST(RunDirectoryTest, ResultHasTheSchemaOfTheDesign) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  run.WriteResult(MakeDocument());
  const Json json = Json::parse(ReadFile(run.result_path()));
  const auto keys_of = [](const Json& object) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.push_back(key);
    return keys;
  };
  EXPECT_THAT(keys_of(json),
              ElementsAre("schema", "scenario", "method", "seed", "theta", "test", "rollouts", "wall_s"));
  EXPECT_THAT(keys_of(json["theta"]), ElementsAre("names", "lower", "upper", "initial", "learned"));
  EXPECT_THAT(keys_of(json["test"]), ElementsAre("variations", "seed", "initial", "learned"));
  EXPECT_THAT(keys_of(json["test"]["initial"]), ElementsAre("loss_mean", "loss_std", "success_rate"));
  EXPECT_THAT(keys_of(json["test"]["learned"]), ElementsAre("loss_mean", "loss_std", "success_rate"));
  EXPECT_THAT(keys_of(json["rollouts"]), ElementsAre("total", "distinct", "reissued"));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["seed"].get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(json["theta"]["learned"].get<std::vector<double>>(), MakeDocument().learned);  // to the last bit
  EXPECT_EQ(json["test"]["learned"]["success_rate"], 0.98);
  const Json evaluation = Json::parse(ReadFile(run.evaluation_path()));
  EXPECT_EQ(evaluation["learned"]["loss_mean"], 0.1);
  EXPECT_EQ(evaluation["initial"]["not_converged"], 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(run.path()), fs::directory_iterator()), 2);  // nothing temporary
}

TEST(RunDirectoryTest, WhatNobodyTestsAndWhatHasNoFiniteLossIsNull) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  ResultDocument document = MakeDocument();
  document.has_success = false;
  const double infinity = std::numeric_limits<double>::infinity();
  document.test_initial.loss_mean = document.test_initial.loss_std = infinity;
  document.test_initial.worst_decile_loss = infinity;
  document.test_initial.loss_interval = {infinity, infinity};
  run.WriteResult(document);
  const Json result = Json::parse(ReadFile(run.result_path()));
  for (const char* design : {"initial", "learned"}) EXPECT_TRUE(result["test"][design]["success_rate"].is_null());
  EXPECT_TRUE(result["test"]["initial"]["loss_mean"].is_null());
  EXPECT_EQ(result["test"]["learned"]["loss_mean"], 0.1);
  const Json evaluation = Json::parse(ReadFile(run.evaluation_path()));
  for (const char* figure : {"loss_mean", "loss_std", "loss_mean_95", "worst_decile_loss", "success_rate_95"}) {
    EXPECT_TRUE(evaluation["initial"][figure].is_null()) << figure;
  }
  EXPECT_FALSE(evaluation["learned"]["loss_mean_95"].is_null());
}

TEST(RunDirectoryTest, NumbersThatJsonCannotHoldAreAnError) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  ResultDocument document = MakeDocument();
  document.learned[1] = std::numeric_limits<double>::quiet_NaN();
  try {
    run.WriteResult(document);
    FAIL() << "NaN was written";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/theta/learned/1"));
  }
  EXPECT_FALSE(fs::exists(run.result_path()));
  document = MakeDocument();
  document.test_initial.loss_std = std::numeric_limits<double>::infinity();
  EXPECT_THROW(run.WriteResult(document), std::runtime_error);
  document = MakeDocument();
  document.learned.pop_back();
  EXPECT_THROW(run.WriteResult(document), std::invalid_argument);
  document = MakeDocument();
  document.test_initial.seed = 78;
  EXPECT_THROW(run.WriteResult(document), std::invalid_argument);
  EXPECT_TRUE(fs::is_empty(run.path()));
}

TEST(RunDirectoryTest, AFailedReplacementKeepsTheOldFile) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "file", "old");
  fs::create_directory(folder / "file.tmp");  // the temporary file cannot be opened
  EXPECT_THROW(WriteFileAtomically(folder / "file", "new"), std::system_error);
  EXPECT_EQ(ReadFile(folder / "file"), "old");
}

TEST(RunLogsTest, MetricsTimesIncreaseStrictlyAndNumbersReadBack) {
  const TemporaryFolder folder;
  {
    MetricsLog log(folder / "metrics.csv", {"width", "depth, left"});
    for (const double time_s : {0.5, 0.5, 0.4, 0.5000011, 0.7, 0.7}) log.Append(time_s, MakeEvaluation(0, 1.0 / 3.0));
    LearningEvaluation rejected = MakeEvaluation(6, std::numeric_limits<double>::infinity());
    rejected.value.accepted = false;
    BatchValidation validation;
    validation.test.loss_mean = 0.25;
    validation.test.success_rate = 0.5;
    log.SetValidation(validation, true);
    log.Append(0.8, rejected);
  }
  const std::vector<std::string> lines = ReadLines(folder / "metrics.csv");
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0],
            "time_s,batch,evaluation,loss,task_loss,distillation_loss,gradient_norm,best_loss,accepted,successes,"
            "rollouts,untrusted,validation_loss,validation_success,width,\"depth, left\"");
  EXPECT_EQ(lines[1],
            "0.500000,1,0,0.3333333333333333,0.3333333333333333,0,0,0.3333333333333333,1,0,5,0,,,"
            "0.30000000000000004,-1e-300");
  double last = -1.0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const double time_s = std::stod(lines[i].substr(0, lines[i].find(',')));
    EXPECT_GT(time_s, last);
    last = time_s;
  }
  EXPECT_EQ(last, 0.8);
  EXPECT_THAT(lines[7], HasSubstr(",inf,inf,0,0,inf,0,"));
  EXPECT_THAT(lines[7], HasSubstr(",0.25,0.5,"));

  MetricsLog again(folder / "metrics.csv", {"width", "depth"});  // a resumed run repeats its rows
  again.Append(0.1, MakeEvaluation(0, 1.0));
  EXPECT_EQ(ReadLines(folder / "metrics.csv").size(), 2u);
}

TEST(RunLogsTest, RolloutsGoOnAfterACrash) {
  const TemporaryFolder folder;
  const RolloutRow row{.time_s = 1.5,
                       .id = "ab12",
                       .kind = "task",
                       .variation = {0.01, -0.02},
                       .worker = "node \"7\", a",
                       .attempt = 2,
                       .loss = 0.25,
                       .success = true,
                       .converged = true,
                       .gradient_reliable = true,
                       .loss_error = 0.5,
                       .penetration = 0.75,
                       .largest_force = 2.5,
                       .distrust = "pea and tool, both",
                       .forward_s = 0.01,
                       .gradient_s = 0.005,
                       .waited_s = 0.75};
  { RolloutLog(folder / "rollouts.csv").Append(row); }
  std::ofstream(folder / "rollouts.csv", std::ios::app) << "cd34,task,0.";  // killed in the middle of a line
  { RolloutLog(folder / "rollouts.csv").Append(row); }
  EXPECT_THAT(
      ReadLines(folder / "rollouts.csv"),
      ElementsAre("id,kind,variation,worker,attempt,loss,success,converged,gradient_reliable,loss_error,penetration,"
                  "largest_force,distrust,time_s,forward_s,gradient_s,waited_s,held_s",
                  "ab12,task,0.01 -0.02,\"node \"\"7\"\", a\",2,0.25,1,1,1,0.5,0.75,2.5,\"pea and tool, "
                  "both\",1.500000,0.01,0.005,0.750000,",
                  "ab12,task,0.01 -0.02,\"node \"\"7\"\", a\",2,0.25,1,1,1,0.5,0.75,2.5,\"pea and tool, "
                  "both\",1.500000,0.01,0.005,0.750000,"));
}

TEST(RunLogsTest, EventsAreOneObjectALine) {
  const TemporaryFolder folder;
  { EventLog(folder / "events.jsonl").Append(0.25, "batch_start", {{"batch", 1}, {"text", "two\nlines"}}); }
  std::ofstream(folder / "events.jsonl", std::ios::app) << "{\"time_s\": 0.";
  EventLog log(folder / "events.jsonl");
  log.Append(0.5, "resumed", Json::object());
  EXPECT_THROW(log.Append(1.0, "bad", {{"loss", std::numeric_limits<double>::quiet_NaN()}}), std::runtime_error);
  EXPECT_THAT(ReadLines(folder / "events.jsonl"),
              ElementsAre("{\"time_s\":0.25,\"event\":\"batch_start\",\"batch\":1,\"text\":\"two\\nlines\"}",
                          "{\"time_s\":0.5,\"event\":\"resumed\"}"));
}

TEST(EarlierLifeTest, CountsWhatTheLogsSay) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder / "run");
  EXPECT_EQ(ReadEarlierLife(run).worked_s, 0.0);
  EXPECT_EQ(ReadEarlierLife(run).reissued, 0);
  {
    EventLog events(run.events_path());
    RolloutLog rollouts(run.rollouts_path());
    events.Append(0.5, "begin", {{"pid", 1}});
    events.Append(2.0, "requests_reissued", {{"count", 2}, {"total", 2}});
    events.Append(3.0, "requests_reissued", {{"count", 3}, {"total", 5}});
    rollouts.Append({.time_s = 3.75, .id = "ab", .kind = "task", .variation = {0.5, 1.0}, .worker = "w"});
    // Commas in a text shift no column.
    rollouts.Append({.time_s = 4.5,
                     .id = "ac",
                     .kind = "test",
                     .variation = {},
                     .worker = "w",
                     .distrust = "a and b, 1,000,000%, 99"});
  }
  EXPECT_EQ(ReadEarlierLife(run).worked_s, 4.5);
  EXPECT_EQ(ReadEarlierLife(run).reissued, 5);
  std::ofstream(run.events_path(), std::ios::app) << "{\"time_s\": 9.0, \"eve";  // a crash in mid-line
  EXPECT_EQ(ReadEarlierLife(run).worked_s, 4.5);
}

}  // namespace run_directory_test
}  // namespace knap
