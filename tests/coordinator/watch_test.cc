// What bystanders make of a bus: the status of a cluster, and whether a recording tells a journal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "coordinator/dispatch/answer_cache.h"
#include "coordinator/watch/cluster_view.h"
#include "coordinator/watch/prometheus_text.h"
#include "coordinator/watch/run_recording.h"
#include "coordinator/watch/status_text.h"
#include "lcmtypes/wire/channels.h"

namespace knap {
namespace watch_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::int64_t kSecond = 1'000'000;

template <typename T>
Message MakeMessage(std::string_view channel, const T& message, std::int64_t arrival_us, const RunKey& key = RunKey()) {
  return {std::string(channel), Seal(message, key), arrival_us};
}

worker_status_t MakeWorker(const std::string& name, std::int64_t instance, std::int64_t sequence,
                           std::int64_t finished) {
  worker_status_t status{};
  status.sender = instance;
  status.sequence = sequence;
  status.run_id = 5;
  status.state = worker_status_t::kComputing;
  status.name = name;
  status.host = "node";
  status.engine = "knap";
  status.finished = finished;
  status.step_fraction = 0.25;
  return status;
}

run_status_t MakeRun(std::int64_t sequence) {
  run_status_t status{};
  status.run_id = status.sender = 5;
  status.sequence = sequence;
  status.state = run_status_t::kLearning;
  status.progress = 0.5;
  status.eta_s = 90.0;
  status.requests_reissued = 3;
  status.rollouts_untrusted = 4;
  status.gradients_flagged = 7;
  status.workers = 2;
  status.scenario = "pushing";
  status.method = "ours";
  return status;
}

// One line a sample, in the format that promtool and node_exporter read.
TEST(ClusterViewTest, SpeaksPrometheus) {
  ClusterView view{RunKey()};
  run_status_t run = MakeRun(1);
  run.scenario = "push \"it\" \\ far";
  run.loss = std::nan("");
  run.best_loss = std::numeric_limits<double>::infinity();
  view.Handle(MakeMessage(kRunStatusChannel, run, kSecond));
  view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("a", 7, 1, 10), kSecond));
  view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("b", 8, 1, 20), kSecond));
  const std::string text = FormatPrometheus(view, 3 * kSecond);
  const std::string labels = R"({scenario="push \"it\" \\ far",method="ours",run="0000000000000005"} )";
  EXPECT_THAT(text, HasSubstr("# HELP knap_run_progress_ratio Share of the run that is done.\n"
                              "# TYPE knap_run_progress_ratio gauge\nknap_run_progress_ratio" +
                              labels + "0.5\n"));
  EXPECT_THAT(text, HasSubstr("\nknap_run_requests_reissued_total" + labels + "3\n"));
  EXPECT_THAT(text, HasSubstr("\nknap_run_best_loss" + labels + "+Inf\n"));
  EXPECT_THAT(text, Not(HasSubstr("knap_run_loss")));
  EXPECT_THAT(text, HasSubstr("# TYPE knap_worker_finished_total counter\n"
                              "knap_worker_finished_total{worker=\"a\",host=\"node\",engine=\"knap\","
                              "instance=\"0000000000000007\"} 10\n"
                              "knap_worker_finished_total{worker=\"b\",host=\"node\",engine=\"knap\","
                              "instance=\"0000000000000008\"} 20\n"));
  EXPECT_THAT(text, HasSubstr("knap_worker_silence_seconds{worker=\"a\",host=\"node\",engine=\"knap\","
                              "instance=\"0000000000000007\"} 2\n"));
  EXPECT_EQ(FormatPrometheus(ClusterView{RunKey()}, 0), "");
}

TEST(ClusterViewTest, TellsRatesStatesAndSilence) {
  ClusterView view{RunKey()};
  view.Handle(MakeMessage(kRunStatusChannel, MakeRun(1), 0));
  for (int i = 0; i <= 8; ++i) {  // 10 answers a second
    view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("alice", 1, 10 + i, 100 + 5 * i), i * kSecond / 2));
  }
  view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("bob", 2, 1, 7), kSecond));
  view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("alice", 1, 12, 0), 4 * kSecond));  // overtaken: ignored
  view.Handle(MakeMessage(kWorkerStatusChannel, MakeWorker("eve", 3, 1, 0), 4 * kSecond, RunKey::MakeRandom()));
  ASSERT_EQ(view.workers().size(), 2u);
  EXPECT_NEAR(view.workers().at(1).CalcRate(), 10.0, 1e-9);
  EXPECT_EQ(view.workers().at(2).CalcRate(), 0.0);
  EXPECT_EQ(view.refusals().corrupt, 1);

  const std::string text = FormatStatus(view, {}, 4 * kSecond, 100, false);
  EXPECT_THAT(text, AllOf(HasSubstr("pushing ours  learning  50%  ETA 1:30"), HasSubstr("retries 3"),
                          HasSubstr("not to be trusted: 4 rollouts, 7 gradients"), HasSubstr("alice"),
                          HasSubstr("silent 3"), HasSubstr("computing"), Not(HasSubstr("\x1b"))));
  EXPECT_THAT(FormatStatus(view, {}, 4 * kSecond, 100, true), HasSubstr("\x1b[33mbob"));
  std::istringstream lines(FormatStatus(view, {}, 4 * kSecond, 30, false));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 30u) << line;

  const auto json = MakeStatusJson(view, {}, 4 * kSecond, "udpm://");
  EXPECT_EQ(json["runs"][0]["retries"], 3);
  EXPECT_EQ(json["runs"][0]["rollouts_untrusted"], 4);
  EXPECT_EQ(json["runs"][0]["gradients_flagged"], 7);
  EXPECT_EQ(json["runs"][0]["state"], "learning");
  EXPECT_EQ(json["runs"][0]["eta_s"], 90.0);
  EXPECT_EQ(json["workers"][0]["name"], "alice");
  EXPECT_EQ(json["workers"][0]["finished"], 140);
  EXPECT_EQ(json["workers"][1]["age_s"], 3.0);
  EXPECT_EQ(json["messages_refused"], 1);

  worker_status_t goodbye = MakeWorker("bob", 2, 2, 7);
  goodbye.state = worker_status_t::kStopping;
  view.Handle(MakeMessage(kWorkerStatusChannel, goodbye, 5 * kSecond));
  EXPECT_EQ(view.workers().count(2), 0u);
  view.Forget(40 * kSecond);
  EXPECT_TRUE(view.workers().empty());
  EXPECT_THAT(FormatStatus(view, {}, 40 * kSecond, 100, false), AllOf(HasSubstr("no run"), HasSubstr("no workers")));
}

TEST(StatusTextTest, LossesHaveTheirUnitsWhereARunIsKnown) {
  ClusterView view{RunKey()};
  run_status_t run = MakeRun(1);
  run.loss = 12.5;
  run.best_loss = std::nan("");
  view.Handle(MakeMessage(kRunStatusChannel, run, 0));
  const KnownRuns tested = {{5, {" mm²", true}}}, untested = {{5, {" cm", false}}}, another = {{6, {" cm", false}}};
  EXPECT_THAT(FormatStatus(view, tested, 0, 120, false),
              AllOf(HasSubstr("loss 12.5 mm²  best -  gradient"), Not(HasSubstr("success"))));
  EXPECT_THAT(FormatStatus(view, untested, 0, 120, false),
              AllOf(HasSubstr("elapsed 0:00  no success test\n"), HasSubstr("loss 12.5 cm  best -  gradient")));
  EXPECT_THAT(FormatStatus(view, another, 0, 120, false),
              AllOf(HasSubstr("loss 12.5 (unit not known)  best -  gradient"), Not(HasSubstr("success"))));
  const auto json = MakeStatusJson(view, untested, 0, "udpm://")["runs"][0];
  EXPECT_EQ(json["loss"], 12.5);
  EXPECT_TRUE(json["best_loss"].is_null());
  EXPECT_EQ(json["loss_unit"], "cm");
  EXPECT_EQ(json["success_test"], false);
  EXPECT_TRUE(MakeStatusJson(view, another, 0, "udpm://")["runs"][0]["loss_unit"].is_null());
  EXPECT_TRUE(MakeStatusJson(view, another, 0, "udpm://")["runs"][0]["success_test"].is_null());
}

TEST(StatusTextTest, OddNamesNeitherReachTheTerminalNorEndTheProgram) {
  ClusterView view{RunKey()};
  worker_status_t odd = MakeWorker("alice", 1, 1, 0);
  odd.host = "\x1b[2J\xff\xfehost";
  view.Handle(MakeMessage(kWorkerStatusChannel, odd, 0));
  run_status_t run = MakeRun(1);
  run.scenario = "t\xc3\xa4st\n\xe6";
  view.Handle(MakeMessage(kRunStatusChannel, run, 0));
  const std::string text = FormatStatus(view, {}, 0, 100, false);
  EXPECT_THAT(text,
              AllOf(HasSubstr("alice"), HasSubstr("[2J??host"), HasSubstr("t\xc3\xa4st ?"), Not(HasSubstr("\x1b"))));
  EXPECT_EQ(MakeStatusJson(view, {}, 0, "udpm://")["workers"][0]["host"], " [2J??host");
  EXPECT_NO_THROW(static_cast<void>(MakeStatusJson(view, {}, 0, "udpm://").dump()));
  // Every width cuts the line somewhere; never inside the character of two bytes.
  for (int width = 1; width < 40; ++width) {
    EXPECT_NO_THROW(static_cast<void>(nlohmann::json(FormatStatus(view, {}, 0, width, false)).dump())) << width;
  }
}

// Three answers of a run 5 by one worker, recorded from the beginning.
class RunRecordingTest : public ::testing::Test {
 protected:
  RunRecordingTest() {
    const worker_status_t status = MakeWorker("alice", 1, 1, 0);
    events_.push_back(MakeMessage(kWorkerStatusChannel, status, 0, key_));
    for (int i = 0; i < 3; ++i) {
      rollout_request_t request{};
      request.run_id = request.sender = 5;
      request.receiver = 1;
      assignment_t assignment{};
      assignment.gradient = 1;
      assignment.theta_size = 90;
      assignment.control_size = 10;  // together in two parts
      assignment.variation_size = 1;
      std::vector<double> values(101, 0.5 * i);
      const std::span<const double> all(values);
      const ContentId id =
          CalcRequestId({"knap", ContentId{}, all.first(90), all.subspan(90, 10), {}, all.subspan(100), true});
      CopyId(id, assignment.id);
      ForEachPart(values, [&](std::int32_t first, std::span<const double> part) {
        assignment.first_value = first;
        assignment.values.assign(part.begin(), part.end());
        request.assignments = {assignment};
        events_.push_back(MakeMessage("KNAP_REQUEST_alice", request, 0, key_));
      });
      rollout_result_t result{};
      result.run_id = 5;
      result.sender = 1;
      result.loss = 1.0 + i;
      result.finite = result.converged = result.gradient_reliable = 1;
      result.gradient_size = 100;
      result.worker = "alice";
      CopyId(id, result.id);
      const std::vector<double> gradient(100, 0.25);
      ForEachPart(gradient, [&](std::int32_t first, std::span<const double> part) {
        result.first_value = first;
        result.values.assign(part.begin(), part.end());
        results_.push_back(events_.size());
        events_.push_back(MakeMessage(kResultChannel, result, 0, key_));
      });
      journal_.emplace_back(id, MakeOutcome(result, gradient));
    }
  }

  std::string Verify(bool finished = true) {
    RunRecording recording(key_, {5}, journal_, finished);
    for (std::size_t i = 0; i < events_.size(); ++i) {
      recording.Add(static_cast<std::int64_t>(i), events_[i].channel, events_[i].bytes);
    }
    return recording.FindDifference().value_or("");
  }

  const RunKey key_ = RunKey::MakeRandom();
  std::vector<Message> events_;
  std::vector<std::size_t> results_;  // their places in events_
  std::vector<RunRecording::Answer> journal_;
};

TEST_F(RunRecordingTest, TellsItsJournalEvenWithRepeats) {
  EXPECT_EQ(Verify(), "");
  const std::vector<Message> once = events_;
  events_.insert(events_.end(), once.begin(), once.end());
  EXPECT_EQ(Verify(), "");
}

TEST_F(RunRecordingTest, OtherBitsAreNamed) {
  journal_[1].second.loss = std::nextafter(2.0, 3.0);
  EXPECT_THAT(Verify(), AllOf(HasSubstr("event 7"), HasSubstr(FormatHex(journal_[1].first)),
                              HasSubstr("loss is 0x1p+1 "
                                        "instead of")));
  journal_[1].second.loss = 2.0;
  journal_[2].second.gradient[99] = -0.25;
  EXPECT_THAT(Verify(), AllOf(HasSubstr("event 12"), HasSubstr("gradient[99]")));
}

TEST_F(RunRecordingTest, DamagedAndMissingMessagesAreNamed) {
  const std::vector<Message> whole = events_;
  events_[results_[3]].bytes[100] ^= 1;  // half of the second answer is gone
  EXPECT_THAT(Verify(), AllOf(HasSubstr("answer 2"), HasSubstr("no result")));
  events_ = whole;
  events_.erase(events_.begin() + 1);
  EXPECT_THAT(Verify(), AllOf(HasSubstr("answer 1"), HasSubstr("is not in the recording")));
  events_ = whole;
  events_.erase(events_.begin());
  EXPECT_THAT(Verify(), HasSubstr("no status"));
}

TEST_F(RunRecordingTest, RequestsThatAreNotWhatTheirIdSaysAreNamed) {
  auto request = Open<rollout_request_t>(events_[2].bytes.data(), events_[2].bytes.size(), key_, nullptr);
  ASSERT_TRUE(request.has_value());
  request->assignments.at(0).values.back() += 1.0;
  events_[2].bytes = Seal(*request, key_);
  EXPECT_THAT(Verify(), AllOf(HasSubstr("event 2"), HasSubstr("asks what would be request")));
}

TEST_F(RunRecordingTest, AnswersBeyondTheJournalOfAFinishedRunAreNamed) {
  journal_.pop_back();
  EXPECT_THAT(Verify(true), HasSubstr("of which the journal knows nothing"));
  EXPECT_EQ(Verify(false), "");  // it may just not have been written yet
}

TEST_F(RunRecordingTest, AnotherKeyOrRunTellsNothing) {
  RunRecording stranger(RunKey(), {5}, journal_, true);
  RunRecording other(key_, {6}, journal_, true);
  for (const Message& event : events_) {
    stranger.Add(0, event.channel, event.bytes);
    other.Add(0, event.channel, event.bytes);
  }
  EXPECT_THAT(stranger.FindDifference().value_or(""), HasSubstr("answer 1"));
  EXPECT_EQ(stranger.counters().refused.corrupt, static_cast<std::int64_t>(events_.size()));
  EXPECT_THAT(other.FindDifference().value_or(""), HasSubstr("answer 1"));
}

}  // namespace watch_test
}  // namespace knap
