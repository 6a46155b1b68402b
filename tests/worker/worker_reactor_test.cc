#include "worker/worker_reactor.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/wire/scenario_bundle.h"
#include "lcmtypes/wire/sender.h"
#include "tests/worker/closed_form_engine.h"
#include "tests/worker/simulated_worker.h"

namespace knap {
namespace {

constexpr std::int64_t kRun = 7;
constexpr std::int64_t kInstance = 42;
constexpr std::int64_t kJobUs = 100'000;

// Plays the coordinator by hand, message by message.
class WorkerReactorTest : public ::testing::Test {
 protected:
  WorkerReactorTest() { Advance(1000); }

  void Advance(std::int64_t us) {
    network_.Advance(network_.now_us() + us, [] { return false; });
    while (const auto message = transport_->Receive(0)) {
      RefusalCounters refusals;
      if (auto status = Open<worker_status_t>(message->bytes, key_, &refusals)) statuses_.push_back(*status);
      if (auto result = Open<rollout_result_t>(message->bytes, key_, &refusals)) results_.push_back(*result);
      if (auto control = Open<control_t>(message->bytes, key_, &refusals)) wants_.push_back(*control);
    }
  }

  control_t MakeControl(std::int32_t kind, const std::vector<ContentId>& ids = {}) {
    control_t control{};
    control.receiver = kInstance;
    control.kind = kind;
    CopyId(scenario_, control.scenario);
    for (const ContentId& id : ids) AppendId(id, &control.ids);
    return control;
  }
  void SendControl(std::int32_t kind, const std::vector<ContentId>& ids = {}, std::int64_t run_id = kRun) {
    sender_.Publish("KNAP_CONTROL_w", run_id, MakeControl(kind, ids));
    Advance(1000);
  }

  void SendPieces(const std::vector<std::int32_t>& chunks) {
    for (const std::int32_t chunk : chunks) {
      const std::size_t begin = static_cast<std::size_t>(chunk) * kBundleChunkSize;
      scenario_t piece{};
      piece.chunk = chunk;
      piece.chunk_count = static_cast<std::int32_t>((bundle_.size() + kBundleChunkSize - 1) / kBundleChunkSize);
      piece.total_size = static_cast<std::int32_t>(bundle_.size());
      const std::string data = bundle_.substr(begin, kBundleChunkSize);
      piece.data.assign(data.begin(), data.end());
      CopyId(scenario_, piece.scenario);
      sender_.Publish(kScenarioChannel, kRun, piece);
    }
    Advance(1000);
  }

  void Join() {
    SendControl(control_t::kJoin);
    while (!wants_.empty()) {
      const std::vector<std::int32_t> chunks = wants_.back().chunks;
      wants_.clear();
      SendPieces(chunks);
    }
  }

  assignment_t MakeAssignment(double theta) const {
    assignment_t assignment{};
    assignment.attempt = 1;
    assignment.gradient = 1;
    assignment.theta_size = 4;
    assignment.variation_size = 1;
    assignment.values = {theta, 1.0, 2.0, 3.0, 0.5};
    CopyId(CalcId(theta), assignment.id);
    return assignment;
  }
  rollout_request_t MakeRequest(double theta) {
    rollout_request_t request{};
    request.receiver = kInstance;
    request.assignments.push_back(MakeAssignment(theta));
    CopyId(scenario_, request.scenario);
    return request;
  }
  ContentId CalcId(double theta) const {
    const std::vector<double> values = {theta, 1.0, 2.0, 3.0};
    const std::vector<double> variation = {0.5};
    return CalcRequestId({"closed-form", scenario_, values, {}, {}, variation, true});
  }
  void SendRequest(const rollout_request_t& request, std::int64_t run_id = kRun) {
    sender_.Publish("KNAP_REQUEST_w", run_id, request);
    Advance(1000);
  }

  int CountResults(double theta) const {
    int count = 0;
    for (const rollout_result_t& result : results_) count += MakeId(result.id) == CalcId(theta) ? 1 : 0;
    return count;
  }

  SimulatedNetwork network_{3};
  RunKey key_;
  std::string bundle_ = EncodeBundle({{"scenario.txt", "dimension 4\n"}, {"mesh", std::string(40'000, 'x')}});
  ContentId scenario_ = CalcScenarioId(bundle_);
  ClosedFormEngine engine_;
  std::vector<worker_status_t> statuses_;
  std::vector<rollout_result_t> results_;
  std::vector<control_t> wants_;
  std::unique_ptr<SimulatedTransport> transport_ = network_.Connect(
      {std::string(kWorkerStatusChannel), std::string(kResultChannel), std::string(kControlChannel)}, {});
  Sender sender_{kRun, key_, transport_.get(), &network_};
  bool lacks_ = false;  // the next computation lacks memory
  SimulatedWorker worker_{&network_, &engine_, "w", kInstance,
                          [this] { return lacks_ ? SimulatedExecutor::kLacks : kJobUs; }};
};

// A bus on which there is always another message, each costing 10 us of an own clock.
class FloodedTransport : public Transport, public Clock {
 public:
  std::int64_t now_us() const override { return now_us_; }
  std::int64_t wall_us() const override { return now_us_; }
  void Publish(const std::string& channel, const std::vector<std::uint8_t>&) override {
    if (channel == kWorkerStatusChannel) statuses_us.push_back(now_us_);
  }
  std::optional<Message> Receive(std::int64_t) override {
    now_us_ += 10;
    return Message{"KNAP_CONTROL_w", {1, 2, 3}, now_us_};
  }
  void Wake() override {}
  TransportCounters counters() const override { return {}; }

  std::vector<std::int64_t> statuses_us;

 private:
  std::int64_t now_us_ = 0;
};

TEST(WorkerFloodTest, ItsStatusGoesOn) {
  FloodedTransport bus;
  ClosedFormEngine engine;
  SimulatedExecutor executor(&engine, &bus, [] { return kJobUs; });
  WorkerReactor reactor({"w", kInstance, engine.identity(), "host", 1}, RunKey(), &bus, &bus, &executor);
  while (bus.now_us() < 2'000'000) reactor.Turn(100'000);
  ASSERT_EQ(bus.statuses_us.size(), 8u);  // at 4 Hz
  for (std::size_t i = 1; i < bus.statuses_us.size(); ++i) {
    EXPECT_LT(bus.statuses_us[i] - bus.statuses_us[i - 1], 300'000) << i;
  }
}

TEST_F(WorkerReactorTest, LackOfMemoryIsSaidAndIsNoAnswer) {
  Join();
  SendRequest(MakeRequest(1.0));
  SendRequest(MakeRequest(2.0));
  lacks_ = true;
  SendRequest(MakeRequest(3.0));
  Advance(10 * kJobUs);
  EXPECT_TRUE(worker_.reactor().stopped());
  EXPECT_EQ(worker_.reactor().lack(), "out of memory");
  EXPECT_EQ(statuses_.back().state, worker_status_t::kStopping);
  EXPECT_EQ(statuses_.back().reason, "out of memory");
  EXPECT_EQ(MakeId(statuses_.back().running), CalcId(2.0));  // the one that it could not compute
  EXPECT_GE(CountResults(1.0), 1);
  EXPECT_EQ(CountResults(2.0), 0);
  for (const rollout_result_t& result : results_) EXPECT_EQ(result.status, rollout_result_t::kOk);
}

TEST_F(WorkerReactorTest, AnnouncesItselfAtFourHertz) {
  ASSERT_EQ(statuses_.size(), 1u);  // at once
  EXPECT_EQ(statuses_[0].run_id, 0);
  EXPECT_EQ(statuses_[0].sender, kInstance);
  EXPECT_EQ(statuses_[0].name, "w");
  EXPECT_EQ(statuses_[0].engine, engine_.identity().name);
  EXPECT_EQ(statuses_[0].build, engine_.identity().build);
  EXPECT_EQ(MakeId(statuses_[0].fingerprint), engine_.identity().fingerprint);
  EXPECT_EQ(statuses_[0].protocol, kProtocolVersion);
  Advance(2'000'000);
  EXPECT_EQ(statuses_.size(), 9u);
}

TEST_F(WorkerReactorTest, JoinsAndLoadsTheScenario) {
  Join();
  EXPECT_EQ(statuses_.back().run_id, kRun);
  Advance(300'000);
  EXPECT_EQ(MakeId(statuses_.back().scenario), scenario_);
  EXPECT_EQ(statuses_.back().state, worker_status_t::kIdle);
}

TEST_F(WorkerReactorTest, AsksAgainForLostPiecesAlone) {
  SendControl(control_t::kJoin);
  SendPieces({0});
  Advance(1000);
  ASSERT_EQ(wants_.back().chunks.size(), static_cast<std::size_t>(kChunksPerControl));
  std::vector<std::int32_t> chunks = wants_.back().chunks;
  const std::int32_t lost = chunks[5];
  chunks.erase(chunks.begin() + 5);
  wants_.clear();
  SendPieces(chunks);
  EXPECT_TRUE(wants_.empty());  // it waits a while for the missing one
  Advance(150'000);
  ASSERT_FALSE(wants_.empty());
  EXPECT_EQ(wants_[0].chunks[0], lost);
}

TEST_F(WorkerReactorTest, AnswersAndRepeatsUntilAcknowledged) {
  Join();
  SendRequest(MakeRequest(1.0));
  Advance(kJobUs);
  ASSERT_EQ(CountResults(1.0), 1);
  EXPECT_EQ(results_[0].status, rollout_result_t::kOk);
  EXPECT_EQ(results_[0].gradient_size, 4);
  EXPECT_EQ(results_[0].values[0], 1.0 * (1.0 - 0.5));  // w_0 (theta_0 - t_0)
  EXPECT_EQ(results_[0].worker, "w");
  Advance(1'000'000);
  const int before = CountResults(1.0);
  EXPECT_GE(before, 4);
  SendControl(control_t::kAcknowledge, {CalcId(1.0)});
  Advance(2'000'000);
  EXPECT_EQ(CountResults(1.0), before);
  EXPECT_EQ(statuses_.back().unacknowledged, 0);
}

TEST_F(WorkerReactorTest, AcknowledgementMayRideOnARequest) {
  Join();
  SendRequest(MakeRequest(1.0));
  Advance(kJobUs);
  rollout_request_t next = MakeRequest(2.0);
  AppendId(CalcId(1.0), &next.acknowledged);
  SendRequest(next);
  const int before = CountResults(1.0);
  Advance(1'000'000);
  EXPECT_EQ(CountResults(1.0), before);
}

TEST_F(WorkerReactorTest, OneMessageMayBringManyRequests) {
  Join();
  rollout_request_t request = MakeRequest(1.0);
  request.assignments.push_back(MakeAssignment(2.0));
  request.assignments.push_back(MakeAssignment(1.0));  // again
  request.assignments.push_back(MakeAssignment(3.0));
  SendRequest(request);
  Advance(3 * kJobUs + 1000);
  for (const double theta : {1.0, 2.0, 3.0}) EXPECT_GE(CountResults(theta), 1) << theta;
  EXPECT_EQ(statuses_.back().repeated, 0);
}

TEST_F(WorkerReactorTest, RepeatedRequestIsAnsweredFromMemory) {
  Join();
  SendRequest(MakeRequest(1.0));
  SendRequest(MakeRequest(1.0));  // runs already
  Advance(kJobUs);
  SendControl(control_t::kAcknowledge, {CalcId(1.0)});
  const int before = CountResults(1.0);
  SendRequest(MakeRequest(1.0));
  EXPECT_EQ(CountResults(1.0), before + 1);
  Advance(300'000);
  EXPECT_EQ(statuses_.back().finished, 1);
  EXPECT_EQ(statuses_.back().repeated, 1);
}

TEST_F(WorkerReactorTest, StatusTellsQueueAndSteps) {
  Join();
  Advance(250'000);
  const std::size_t before = statuses_.size();
  Advance(180'000);
  SendRequest(MakeRequest(1.0));
  SendRequest(MakeRequest(2.0));
  Advance(80'000);
  ASSERT_GT(statuses_.size(), before);
  const worker_status_t& status = statuses_.back();
  EXPECT_EQ(status.state, worker_status_t::kComputing);
  EXPECT_EQ(MakeId(status.running), CalcId(1.0));
  EXPECT_EQ(ParseIds(status.queue), (std::vector<ContentId>{CalcId(1.0), CalcId(2.0)}));
  EXPECT_EQ(status.steps_total, 10);
  EXPECT_GT(status.steps_done, 3);
  EXPECT_LT(status.steps_done, 10);
  EXPECT_GT(status.busy_fraction, 0.1);
  EXPECT_LT(status.busy_fraction, 0.6);
}

TEST_F(WorkerReactorTest, CancelledRequestDoesNotRun) {
  Join();
  SendRequest(MakeRequest(1.0));
  SendRequest(MakeRequest(2.0));
  SendControl(control_t::kCancel, {CalcId(2.0)});
  Advance(1'000'000);
  EXPECT_GE(CountResults(1.0), 1);
  EXPECT_EQ(CountResults(2.0), 0);
}

TEST_F(WorkerReactorTest, RequestOvertakenByItsCancellationDoesNotRun) {
  Join();
  rollout_request_t request = MakeRequest(1.0);
  request.run_id = request.sender = kRun;
  request.sequence = 1;  // sent long before the cancellation
  SendControl(control_t::kCancel, {CalcId(1.0)});
  transport_->Publish("KNAP_REQUEST_w", Seal(request, key_));
  Advance(1'000'000);
  EXPECT_EQ(CountResults(1.0), 0);
  SendRequest(MakeRequest(1.0));  // asked anew
  Advance(1'000'000);
  EXPECT_GE(CountResults(1.0), 1);
}

TEST_F(WorkerReactorTest, OtherReceiversRunsAndIdsAreRefused) {
  Join();
  rollout_request_t request = MakeRequest(1.0);
  request.receiver = kInstance + 1;
  SendRequest(request);
  SendRequest(MakeRequest(1.0), kRun + 1);
  request = MakeRequest(1.0);
  request.assignments[0].values[0] = 1.5;  // not what the id says
  SendRequest(request);
  request = MakeRequest(1.0);
  request.assignments[0].theta_size = 3;
  SendRequest(request);
  Advance(1'000'000);
  EXPECT_TRUE(results_.empty());
  EXPECT_EQ(worker_.reactor().refusals().malformed, 2);
}

TEST_F(WorkerReactorTest, AnotherRunMustWaitForSilence) {
  Join();
  SendControl(control_t::kJoin, {}, kRun + 1);
  EXPECT_EQ(worker_.reactor().run_id(), kRun);
  Advance(2'500'000);
  SendControl(control_t::kJoin, {}, kRun + 1);
  EXPECT_EQ(worker_.reactor().run_id(), kRun + 1);
}

TEST_F(WorkerReactorTest, RunStatusIsASignOfLife) {
  Join();
  for (int i = 0; i < 5; ++i) {
    sender_.Publish(kRunStatusChannel, kRun, run_status_t{});
    Advance(700'000);
  }
  SendControl(control_t::kJoin, {}, kRun + 1);
  EXPECT_EQ(worker_.reactor().run_id(), kRun);
}

TEST_F(WorkerReactorTest, StopsWhenItsOwnRunSaysSo) {
  Join();
  SendControl(control_t::kStop, {}, kRun + 1);
  EXPECT_FALSE(worker_.reactor().stopped());
  SendControl(control_t::kStop);
  EXPECT_TRUE(worker_.reactor().stopped());
  EXPECT_EQ(statuses_.back().state, worker_status_t::kStopping);
}

TEST_F(WorkerReactorTest, QueueIsBounded) {
  Join();
  for (int i = 0; i < 40; ++i) SendRequest(MakeRequest(i));
  Advance(10'000'000);
  EXPECT_EQ(statuses_.back().finished, kMaxQueue);
}

TEST(ScenarioFetchTest, BytesWithAnotherHashAreNotBelieved) {
  const std::string bundle = EncodeBundle({{"a", "b"}});
  ScenarioFetch fetch(CalcScenarioId(bundle));
  EXPECT_EQ(fetch.ChooseWanted(0, 100), std::vector<std::int32_t>{0});
  EXPECT_TRUE(fetch.ChooseWanted(50, 100).empty());
  EXPECT_EQ(fetch.ChooseWanted(150, 100), std::vector<std::int32_t>{0});
  scenario_t piece{};
  piece.chunk_count = 1;
  piece.total_size = static_cast<std::int32_t>(bundle.size());
  piece.data.assign(bundle.begin(), bundle.end());
  piece.data.back() = 'c';
  CopyId(fetch.scenario(), piece.scenario);
  fetch.Add(piece);
  EXPECT_EQ(fetch.TakeBundle(), nullptr);
  piece.data.back() = 'b';
  fetch.Add(piece);
  const auto taken = fetch.TakeBundle();
  ASSERT_NE(taken, nullptr);
  EXPECT_EQ(*taken, bundle);
}

}  // namespace
}  // namespace knap
