// What `knap explain` makes of a run's files, and of what is heard of a live run.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/explain/explanation.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/run_directory.h"
#include "coordinator/run_directory/run_logs.h"
#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/codec.h"

namespace knap {
namespace explain_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Json = nlohmann::ordered_json;

// 64 digits that begin with these.
std::string MakeId(const std::string& digits) { return digits + std::string(64 - digits.size(), 'e'); }

class ExplainTest : public ::testing::Test {
 protected:
  ExplainTest() {
    RunInfo info;
    info.scenario = "pushing";
    info.method = "ours";
    info.seed = 3;
    info.host = "box";
    info.started = std::chrono::system_clock::time_point(std::chrono::seconds(1738367999));
    info.identity = {{"engine", "knap"}};
    run_.WriteRunInfo(info);
    RolloutLog(run_.rollouts_path());
    Record(0.0, "begin", {{"answers_from_journal", 0}});
  }

  void Record(double time_s, const std::string& event, const Json& details) {
    EventLog(run_.events_path()).Append(time_s, event, details);
  }

  RolloutRow MakeRow(const std::string& digits, double time_s, const std::string& worker, int attempt = 1) {
    RolloutRow row;
    row.id = MakeId(digits);
    row.kind = "task";
    row.time_s = time_s;
    row.worker = worker;
    row.attempt = attempt;
    row.variation = {0.0125, 0.4};
    row.loss = 12.5;
    row.success = row.converged = row.gradient_reliable = true;
    row.forward_s = 0.03;
    row.gradient_s = 0.006;
    row.waited_s = 0.75;
    row.held_s = 0.05;
    return row;
  }

  void Answer(const RolloutRow& row) { RolloutLog(run_.rollouts_path()).Append(row); }

  ExplainedRun Read() {
    ExplainedRun run;
    run.path = "runs/one";
    run.record = ReadRunRecord(run_);
    run.nameless = "no config.yaml";
    run.silence = "it has ended";
    return run;
  }

  TemporaryFolder folder_;
  RunDirectory run_ = RunDirectory::Create(folder_ / "run");
};

TEST_F(ExplainTest, ACalmRunHasNothingToExplain) {
  Answer(MakeRow("aaaa1111bbbb", 1.0, "local-1"));
  RolloutRow test = MakeRow("aaaa2222bbbb", 2.0, "local-2");
  test.kind = "test";
  test.forward_s = 2.5;
  Answer(test);
  Record(2.5, "done", {{"wall_s", 2.5}});
  const ExplainedRun run = Read();
  EXPECT_THAT(
      ExplainRun(run),
      AllOf(HasSubstr("run        runs/one: pushing, ours, seed 3, begun 2025-01-31T23:59:59Z on box\n"),
            HasSubstr("life       0:00 to 0:03, done\n"), HasSubstr("requests   2 answered: 1 task, 1 test\n"),
            HasSubstr("again      none\n"), HasSubstr("workers    none was lost\n"),
            HasSubstr("slowest    aaaa2222bbbb   2.506 s on local-2 (2.500 s forward and 6 ms gradient), test\n"),
            HasSubstr("now        it has ended\n")));
  const std::string one = ExplainRequest(run, MakeId("aaaa1111bbbb"));
  EXPECT_THAT(one,
              AllOf(HasSubstr("request    " + MakeId("aaaa1111bbbb") + "\n"),
                    HasSubstr("kind       task, with gradient\n"), HasSubstr("asked      at 0.250 s\n"),
                    HasSubstr("attempt 1  local-1, given at 0.950 s\n"
                              "           answered at 1.000 s after 50 ms, of which 30 ms forward and 6 ms gradient\n"),
                    HasSubstr("answer     loss 12.5, success\n"), HasSubstr("certified  finite and converged\n"),
                    HasSubstr("           the gradient is reliable\n"),
                    HasSubstr("again      knap rollout runs/one --request aaaa1111bbbb\n")));
  EXPECT_THAT(one, Not(HasSubstr("attempt 2")));
}

TEST_F(ExplainTest, ADeadWorkersRequestsAreToldWithTheirWorkersAndWhy) {
  Record(3.0, "worker_gone",
         {{"worker", "local-2"},
          {"host", "box"},
          {"why", "died"},
          {"requests",
           {{{"id", "aaaa1111bbbb"}, {"attempt", 1}, {"held_s", 0.4}},
            {{"id", "cccc1111bbbb"}, {"attempt", 1}, {"held_s", 0.3}}}}});
  Record(3.0, "requests_reissued", {{"count", 2}, {"total", 2}});
  Answer(MakeRow("aaaa1111bbbb", 3.5, "local-1", 2));
  Answer(MakeRow("cccc1111bbbb", 3.6, "local-1", 2));
  const ExplainedRun run = Read();
  EXPECT_THAT(ExplainRun(run),
              AllOf(HasSubstr("again          2  its worker died (the first: aaaa1111bbbb)\n"),
                    HasSubstr("workers    3.000 s  local-2 on box: died, with 2 requests\n"), Not(HasSubstr("moved"))));
  EXPECT_THAT(ExplainRequest(run, MakeId("aaaa1111bbbb")),
              HasSubstr("attempt 1  local-2, given at 2.600 s\n"
                        "           its worker died at 3.000 s, after 400 ms\n"
                        "attempt 2  local-1, given at 3.450 s\n"
                        "           answered at 3.500 s after 50 ms"));
}

TEST_F(ExplainTest, CopiesMovesAndLostMessagesAreTold) {
  Record(1.0, "requests_copied",
         {{"count", 1},
          {"total", 1},
          {"requests",
           {{{"id", "aaaa1111bbbb"},
             {"attempt", 2},
             {"held_s", 0.5},
             {"worker", "slow"},
             {"time_s", 0.98},
             {"copy_to", "fast"},
             {"copy_attempt", 3}}}}});
  Record(1.2, "requests_resent",
         {{"count", 1},
          {"total", 1},
          {"requests",
           {{{"id", "aaaa1111bbbb"}, {"attempt", 3}, {"held_s", 0.2}, {"worker", "fast"}, {"time_s", 1.18}}}}});
  Answer(MakeRow("aaaa1111bbbb", 1.3, "fast", 3));
  const ExplainedRun run = Read();
  EXPECT_THAT(ExplainRun(run),
              AllOf(HasSubstr("    1  it took long, and an idle worker got a second copy (aaaa1111bbbb)\n"),
                    HasSubstr("    1  a message was lost, and it was sent again (aaaa1111bbbb)\n"),
                    HasSubstr("    1  moved from a worker's queue to a worker that had nothing to do\n")));
  EXPECT_THAT(ExplainRequest(run, MakeId("aaaa1111bbbb")),
              AllOf(HasSubstr("attempt 1  taken from the queue of a worker that had not begun with it"),
                    HasSubstr("attempt 2  slow, given at 0.480 s\n"
                              "           took long: at 0.980 s fast got a second copy\n"
                              "           cancelled at 1.300 s, as fast had answered\n"),
                    HasSubstr("attempt 3  fast, given at 1.250 s, as a second copy: slow took long\n"
                              "           sent again at 1.180 s: the request or its answer was lost on the way\n"
                              "           answered at 1.300 s")));
}

TEST_F(ExplainTest, WhoWasBelievedLostMayAnswer) {
  Record(3.0, "worker_gone",
         {{"worker", "w"},
          {"host", "node"},
          {"why", "silent"},
          {"requests", {{{"id", "aaaa1111bbbb"}, {"attempt", 1}, {"held_s", 1.0}}}}});
  RolloutRow late = MakeRow("aaaa1111bbbb", 4.0, "w");
  late.held_s = std::numeric_limits<double>::quiet_NaN();
  Answer(late);
  EXPECT_THAT(ExplainRequest(Read(), MakeId("aaaa1111bbbb")),
              HasSubstr("attempt 1  w, given at 2.000 s\n"
                        "           its worker was not heard any more at 3.000 s, after 1.000 s\n"
                        "           all the same answered at 4.000 s, of which"));
}

TEST_F(ExplainTest, AnInterruptedRunIsToldLifeByLife) {
  Answer(MakeRow("dddd1111bbbb", 1.5, "local-1"));
  Record(
      2.0, "requests_dropped",
      {{"worker", "local-1"}, {"count", 1}, {"requests", {{{"id", "aaaa1111bbbb"}, {"attempt", 1}, {"held_s", 0.2}}}}});
  Record(2.0, "requests_dropped",
         {{"worker", ""}, {"count", 1}, {"requests", {{{"id", "bbbb1111bbbb"}, {"attempt", 0}, {"held_s", 0.0}}}}});
  Record(2.0, "interrupted", {});
  ExplainedRun run = Read();
  run.silence = "it was interrupted";
  EXPECT_THAT(
      ExplainRequest(run, "bbbb1111bbbb"),
      AllOf(HasSubstr("kind       not on record"), HasSubstr("attempt 1  waited for a worker\n"),
            HasSubstr("           cancelled at 2.000 s, as the run was broken off\n"), HasSubstr("answer     none\n"),
            HasSubstr("now        it was interrupted\n"), HasSubstr("knap rollout runs/one --request bbbb1111bbbb\n")));
  Record(2.1, "begin", {{"answers_from_journal", 7}});
  Answer(MakeRow("aaaa1111bbbb", 2.5, "local-2"));
  Answer(MakeRow("dddd1111bbbb", 2.6, "local-2"));
  Record(3.0, "done", {});
  run = Read();
  EXPECT_THAT(ExplainRun(run),
              AllOf(HasSubstr("lives      0:00 to 0:02, interrupted\n"
                              "           0:02 to 0:03, done; went on with 7 answers of the journal\n"),
                    HasSubstr("requests   3 answered: 3 task\n           1 of them a second time")));
  EXPECT_THAT(ExplainRequest(run, MakeId("aaaa1111bbbb")),
              HasSubstr("attempt 1  local-1, given at 1.800 s\n"
                        "           cancelled at 2.000 s, as the run was broken off while it was open\n"
                        "resumed    at 2.100 s: asked again, as the journal had no answer\n"
                        "attempt 1  local-2, given at 2.450 s\n"));
}

TEST_F(ExplainTest, OldRunsAreExplainedAsFarAsTheyGo) {
  WriteFileAtomically(
      run_.rollouts_path(),
      "id,kind,variation,worker,attempt,loss,success,converged,gradient_reliable,loss_error,penetration,"
      "largest_force,distrust,time_s,forward_s,gradient_s\n" +
          MakeId("aaaa1111bbbb") + ",task,0.1,local-1,2,3.5,0,1,0,,0.01,2,,5.000000,0.25,0.125\n");
  Record(4.0, "workers_lost", {{"count", 1}, {"total", 1}});
  Record(4.0, "requests_reissued", {{"count", 2}, {"total", 2}});
  Record(4.5, "requests_copied", {{"count", 3}, {"total", 3}});
  const ExplainedRun run = Read();
  EXPECT_THAT(ExplainRun(run),
              AllOf(HasSubstr("2 given to another worker, 3 second copies of stragglers; an earlier version of knap"),
                    HasSubstr("workers    1 lost; which, and when, an earlier version of knap did not write down\n")));
  EXPECT_THAT(ExplainRequest(run, MakeId("aaaa1111bbbb")),
              AllOf(HasSubstr("attempt 1  not on record"),
                    HasSubstr("attempt 2  local-1\n           answered at 5.000 s, of which 250 ms forward and 125 ms "
                              "gradient\n"),
                    HasSubstr("the gradient may not be that of the problem"), HasSubstr("no success\n")));
}

TEST_F(ExplainTest, DamagedLinesAreLeftOut) {
  Answer(MakeRow("aaaa1111bbbb", 1.0, "local-1"));
  std::string events = ReadFile(run_.events_path());
  events += "{\"time_s\":1,\"event\":\"worker_gone\",\"requests\":7}\n[1]\n";
  events += "{\"time_s\":\"x\",\"event\":\"worker_gone\",\"worker\":3,\"requests\":[4,{\"id\":5},{\"id\":\"cccc\"}]}\n";
  events += "{\"time_s\":2,\"event\":\"requests_co";
  WriteFileAtomically(run_.events_path(), events);
  EXPECT_THAT(ExplainRun(Read()), HasSubstr("requests   1 answered: 1 task\n"));
  EXPECT_THAT(ExplainRequest(Read(), "cccc"), HasSubstr("answer     none\n"));
}

TEST_F(ExplainTest, APrefixFindsWhatBeginsWithIt) {
  Answer(MakeRow("aaaa1111bbbb", 1.0, "local-1"));
  Answer(MakeRow("aaaa2222bbbb", 1.1, "local-1"));
  Answer(MakeRow("aaaa2222bbbb", 1.2, "local-1"));
  Record(2.0, "requests_dropped",
         {{"worker", ""},
          {"count", 2},
          {"requests", {{{"id", "aaaa1111bbbb"}, {"attempt", 0}}, {{"id", "dddd3333bbbb"}, {"attempt", 0}}}}});
  const ExplainedRun run = Read();
  EXPECT_THAT(FindRequests(run, "aaaa"), ElementsAre(MakeId("aaaa1111bbbb"), MakeId("aaaa2222bbbb")));
  EXPECT_THAT(FindRequests(run, "aaaa2"), ElementsAre(MakeId("aaaa2222bbbb")));
  EXPECT_THAT(FindRequests(run, MakeId("aaaa1111bbbb")), ElementsAre(MakeId("aaaa1111bbbb")));
  EXPECT_THAT(FindRequests(run, "dddd"), ElementsAre("dddd3333bbbb"));
  EXPECT_THAT(FindRequests(run, "dddd3333bbbb00"), ElementsAre("dddd3333bbbb"));  // which is all that is known of it
  EXPECT_THAT(FindRequests(run, "ffff"), IsEmpty());
}

// Ids are hashes of what was asked, so that they tell where in the run it was.
TEST_F(ExplainTest, ThetaAndVariationAreNamed) {
  RunNames names;
  names.engine = "knap";
  names.scenario = CalcSha256("a scenario");
  names.problem.parameters = {{"depth", "gain"}, {0.0, 0.0}, {0.1, 9.0}, {0.02, 1.0}, {"m", ""}};
  names.problem.parameters.controls = 1;
  names.problem.variations = {{{"bodies.pea.position[0]"}, UniformDraw{0.0, 1.0}},
                              {{"pea.angle"}, UniformDraw{0.0, 1.0}}};
  names.learning.seed = 5;
  names.learning.variations = 10;
  names.learning.batch = 5;
  names.tests = 20;
  names.test_seed = 9;
  names.varied = {{"bodies.pea.position[0]", kLength}, {"pea.angle", kAngle}};
  names.loss_unit = " mm²";
  names.has_success = true;
  names.tried = {{1, 0, {0.02, 1.0}}, {1, 1, {0.03, 2.0}}, {2, 0, {0.03, 2.0}}, {2, 1, {0.04, 2.5}}};
  names.learned = {0.04, 2.5};

  const auto make_row = [&](const std::string& kind, const std::vector<double>& theta,
                            const std::vector<double>& reference, const std::vector<double>& variation, bool gradient) {
    RolloutRow row = MakeRow("", 1.0, "local-1");
    row.kind = kind;
    row.variation = variation;
    const std::span<const double> all = theta;
    row.id = FormatHex(
        CalcRequestId({"knap", names.scenario, all.first(1), all.subspan(1), reference, variation, gradient}));
    Answer(row);
    return row.id;
  };
  const std::vector<double> training =
      SampleVariation(names.problem.variations, 5, RandomStream::kTrainingVariations, 3);
  const std::vector<double> tested = SampleVariation(names.problem.variations, 9, RandomStream::kTestVariations, 7);
  const std::string task = make_row("task", {0.03, 2.0}, {}, training, true);
  const std::string distillation = make_row("distillation", {0.04, 2.5}, {0.03, 2.0}, training, true);
  const std::string test = make_row("test", {0.04, 2.5}, {}, tested, false);
  const std::string unknown = make_row("task", {0.05, 2.5}, {}, {0.25, 0.5}, true);
  ExplainedRun run = Read();
  run.names = names;
  EXPECT_THAT(
      ExplainRequest(run, task),
      AllOf(HasSubstr("kind       task, with gradient\n"), HasSubstr("variation  training variation 3 of 0 to 9\n"),
            HasSubstr(fmt::format("           bodies.pea.position[0] {:.6g} mm\n", 1e3 * training[0])),
            HasSubstr(fmt::format("           pea.angle {:.6g} rad\n", training[1])),
            HasSubstr(
                "theta      of batch 1, evaluation 1 in metrics.csv\n           depth 30.00 mm\n           gain 2\n"),
            HasSubstr("loss 12.5 mm², success\n")));
  EXPECT_THAT(
      ExplainRequest(run, distillation),
      AllOf(
          HasSubstr(
              "theta      of batch 2, evaluation 1 in metrics.csv\n           compared with what batch 2 began with\n"),
          HasSubstr("loss 12.5 (distillation)\n")));
  EXPECT_THAT(ExplainRequest(run, test),
              AllOf(HasSubstr("kind       test\n"), HasSubstr("theta      the learned design\n"),
                    HasSubstr("variation  test variation 7 of 0 to 19\n"),
                    HasSubstr("again      knap rollout runs/one --theta learned --variation 7\n")));
  EXPECT_THAT(ExplainRequest(run, unknown),
              AllOf(HasSubstr("theta      of none of the evaluations"), HasSubstr("           pea.angle 0.5 rad\n"),
                    Not(HasSubstr("training variation"))));
}

template <typename T>
Message MakeMessage(std::string_view channel, const T& message) {
  return {std::string(channel), Seal(message, RunKey()), 1'000'000};
}

TEST_F(ExplainTest, ALiveRunTellsWhoHasWhat) {
  ClusterView view{RunKey()};
  run_status_t status{};
  status.run_id = status.sender = 5;
  status.sequence = 1;
  status.state = run_status_t::kLearning;
  status.requests_open = 4;
  status.workers = 1;
  view.Handle(MakeMessage(kRunStatusChannel, status));
  worker_status_t worker{};
  worker.sender = 8;
  worker.sequence = 1;
  worker.run_id = 5;
  worker.state = worker_status_t::kComputing;
  worker.name = "w";
  worker.engine = "knap";
  worker.step_fraction = 0.4;
  const ContentId first = CalcSha256("first"), second = CalcSha256("second");
  CopyId(first, worker.running);
  AppendId(first, &worker.queue);
  AppendId(second, &worker.queue);
  worker.queue_size = static_cast<std::int32_t>(worker.queue.size());
  view.Handle(MakeMessage(kWorkerStatusChannel, worker));
  worker.name = "other";
  worker.sender = 9;
  worker.run_id = 6;
  view.Handle(MakeMessage(kWorkerStatusChannel, worker));
  EXPECT_FALSE(FindLiveRun(view, 7).has_value());
  ExplainedRun run = Read();
  run.live = FindLiveRun(view, 5);
  ASSERT_TRUE(run.live.has_value());
  EXPECT_THAT(ExplainRun(run),
              HasSubstr("now        goes on: 4 requests open, 1 worker\n           w computes " + FormatShort(first) +
                        " (40%), 1 behind it\n           2 with no worker, or on the way to one\n"));
  EXPECT_THAT(FindRequests(run, FormatShort(second)), ElementsAre(FormatHex(second)));
  EXPECT_THAT(ExplainRequest(run, FormatHex(first)), HasSubstr("now        w computes it (40%)\n"));
  EXPECT_THAT(ExplainRequest(run, FormatHex(second)), HasSubstr("now        waits with w, behind 1 more\n"));
  status.sequence = 2;
  status.state = run_status_t::kDone;
  view.Handle(MakeMessage(kRunStatusChannel, status));
  EXPECT_FALSE(FindLiveRun(view, 5).has_value());
}

}  // namespace explain_test
}  // namespace knap
