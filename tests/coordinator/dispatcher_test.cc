#include "coordinator/dispatch/dispatcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "lcmtypes/wire/sender.h"
#include "tests/coordinator/simulated_cluster.h"
#include "tests/support/catch_line.h"

namespace knap {
namespace dispatcher_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(DispatcherTest, KeepsAllWorkersBusy) {
  SimulatedCluster cluster(1);
  cluster.StartWorker("a", 50'000);
  cluster.StartWorker("b", 50'000);
  cluster.dispatcher->Pump(0.1);  // both join and load
  const double begin_s = cluster.now_s();
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(10));
  // Five rounds of 50 ms; what the protocol adds between them is latency alone, hidden by the second credit.
  EXPECT_LT(cluster.now_s() - begin_s, 0.252);
  EXPECT_EQ(cluster.dispatcher->counters().resent, 0);
}

TEST(DispatcherTest, CountsWhatIsNotToBeTrusted) {
  SimulatedCluster cluster(2);
  cluster.StartWorker("a", 100);
  const std::vector<RolloutQuery> queries = SimulatedCluster::MakeQueries(40);
  ExpectRight(&cluster, queries);
  std::int64_t untrusted = 0;
  for (const EngineAnswer& answer : cluster.CalcExpected(queries)) untrusted += answer.distrust.empty() ? 0 : 1;
  EXPECT_GT(untrusted, 0);
  EXPECT_LT(untrusted, 40);
  EXPECT_EQ(cluster.dispatcher->counters().untrusted, untrusted);
  EXPECT_EQ(cluster.dispatcher->counters().flagged, 0);
}

TEST(DispatcherTest, IdleWorkerTakesWhatWaitsBehindASlowOne) {
  for (std::uint64_t seed = 100; seed < 120; ++seed) {  // which of its two requests reaches the slow one first differs
    SimulatedCluster cluster(seed);
    cluster.StartWorker("slow", 1'000'000);
    cluster.StartWorker("fast", 50'000);
    cluster.dispatcher->Pump(0.1);
    const double begin_s = cluster.now_s();
    ExpectRight(&cluster, SimulatedCluster::MakeQueries(4));
    EXPECT_GE(cluster.dispatcher->counters().moved, 1);
    EXPECT_EQ(cluster.dispatcher->counters().reissued, 0);
    EXPECT_LT(cluster.now_s() - begin_s, 1.01) << "seed " << seed;  // instead of two seconds
    EXPECT_LE(cluster.dispatcher->counters().copied, 1) << "seed " << seed;
  }
}

TEST(DispatcherTest, ShortRolloutsAreGivenOutManyAtATime) {
  SimulatedCluster cluster(33);
  cluster.StartWorker("a", 100);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(50));
  const std::int64_t before = cluster.transport->counters().published;
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(400, 1000.0));
  EXPECT_LT(cluster.transport->counters().published - before, 150);  // requests and acknowledgements
}

TEST(DispatcherTest, DeadWorkersAreNotStuck) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 3.0;
  SimulatedCluster cluster(34, options);
  cluster.StartWorker("a", 10'000'000);
  cluster.StartWorker("b", 10'000'000);
  cluster.network.Schedule(1'000'000, [&] { cluster.CrashWorker("a"); });  // and nobody reports it
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2));
  EXPECT_EQ(cluster.dispatcher->counters().workers_lost, 1);
  EXPECT_EQ(cluster.dispatcher->counters().workers_stalled, 0);
}

TEST(DispatcherTest, AnswersAreAcknowledgedOnlyAfterTheCommit) {
  SimulatedCluster cluster(35);
  SimulatedWorker& worker = cluster.StartWorker("a", 1000);
  const auto watcher = cluster.network.Connect({std::string(kWorkerStatusChannel)}, {});
  bool may_commit = false;
  int commits = 0;
  cluster.dispatcher->set_on_commit([&] {
    if (!may_commit) throw std::runtime_error("the disk is full");
    ++commits;
  });
  const auto queries = SimulatedCluster::MakeQueries(10);
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(queries); }), HasSubstr("the disk is full"));
  cluster.network.Advance(cluster.network.now_us() + 1'000'000, [] { return false; });
  std::optional<worker_status_t> status;
  RefusalCounters refusals;
  while (const auto message = watcher->Receive(0)) status = Open<worker_status_t>(message->bytes, RunKey(), &refusals);
  ASSERT_TRUE(status.has_value());
  EXPECT_GT(status->unacknowledged, 0);
  may_commit = true;
  ExpectRight(&cluster, queries);
  cluster.dispatcher->Pump(1.0);
  EXPECT_GT(commits, 0);
  while (const auto message = watcher->Receive(0)) status = Open<worker_status_t>(message->bytes, RunKey(), &refusals);
  EXPECT_EQ(status->unacknowledged, 0);
  EXPECT_EQ(worker.reactor().run_id(), 77);
}

TEST(DispatcherTest, FirstAnswerComesSoonAfterTheStart) {
  SimulatedCluster cluster(2, SimulatedCluster::MakeOptions(),
                           {{"scenario.txt", "dimension 4\nsteps 10\n"}, {"mesh.stl", std::string(200'000, 'm')}});
  cluster.StartWorker("a", 1000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(1));
  EXPECT_LT(cluster.now_s(), 0.1);
}

TEST(DispatcherTest, DeadWorkersRequestsGoToOthersWithinTwoSeconds) {
  SimulatedCluster cluster(3);
  cluster.StartWorker("a", 500'000);
  cluster.StartWorker("b", 500'000);
  cluster.network.Schedule(300'000, [&] { cluster.CrashWorker("a"); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2));  // too few for a second copy
  EXPECT_EQ(cluster.dispatcher->counters().workers_lost, 1);
  EXPECT_GE(cluster.dispatcher->counters().reissued, 1);
  EXPECT_LT(cluster.now_s(), 0.3 + 2.0);
}

TEST(DispatcherTest, ReportedDeathIsFasterThanTheLease) {
  SimulatedCluster cluster(4);
  cluster.StartWorker("a", 200'000);
  cluster.StartWorker("b", 200'000);
  cluster.network.Schedule(300'000, [&] {
    cluster.CrashWorker("a");
    cluster.dispatcher->ReportDeath("a", 1001, DeathCause::kOutside);
  });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(6));
  EXPECT_EQ(cluster.dispatcher->counters().workers_lost, 1);
  EXPECT_LT(cluster.now_s(), 1.1);
}

TEST(DispatcherTest, WorkersMayJoinLate) {
  SimulatedCluster cluster(5);
  cluster.network.Schedule(2'000'000, [&] { cluster.StartWorker("late", 10'000); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(3));
  EXPECT_LT(cluster.now_s(), 2.1);
}

TEST(DispatcherTest, LostResultIsSentAgain) {
  SimulatedCluster cluster(6);
  cluster.StartWorker("a", 100'000);
  cluster.dispatcher->Pump(0.1);
  const double begin_s = cluster.now_s();
  FaultRates all_lost;
  all_lost.drop = 1.0;
  cluster.network.Schedule(cluster.network.now_us() + 50'000, [&] { cluster.network.set_faults(all_lost); });
  cluster.network.Schedule(cluster.network.now_us() + 250'000, [&] { cluster.network.set_faults(FaultRates()); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(1));
  EXPECT_GT(cluster.now_s() - begin_s, 0.25);
  EXPECT_LT(cluster.now_s() - begin_s, 0.5);
}

TEST(DispatcherTest, LongVectorsTravelInParts) {
  SimulatedCluster cluster(7, SimulatedCluster::MakeOptions(), {{"scenario.txt", "dimension 1000\n"}});
  FaultRates faults;
  faults.drop = faults.duplicate = faults.delay = 0.2;
  cluster.network.set_faults(faults);
  cluster.StartWorker("a", 1000);
  RolloutQuery query;
  for (int i = 0; i < 1000; ++i) query.theta.push_back(std::sin(i));
  query.variation = {0.5, -0.25, 1.0};
  ExpectRight(&cluster, {query});
}

TEST(DispatcherTest, EqualQueriesAreComputedOnce) {
  SimulatedCluster cluster(8);
  cluster.StartWorker("a", 1000);
  auto queries = SimulatedCluster::MakeQueries(2);
  queries.push_back(queries[0]);
  ExpectRight(&cluster, queries);
  ExpectRight(&cluster, queries);
  EXPECT_EQ(cluster.dispatcher->counters().requested, 6);
  EXPECT_EQ(cluster.dispatcher->counters().computed, 2);
  EXPECT_EQ(cluster.dispatcher->counters().remembered, 4);
}

TEST(DispatcherTest, ReportsEveryAcceptedAnswerOnce) {
  SimulatedCluster cluster(10);
  cluster.StartWorker("a", 20'000);
  const auto queries = SimulatedCluster::MakeQueries(3);
  std::map<ContentId, double> losses;
  double last_waited_s = 0.0;
  cluster.dispatcher->set_on_result([&](const RolloutReport& report) {
    EXPECT_EQ(cluster.dispatcher->CalcId(*report.query), report.id);
    EXPECT_TRUE(losses.emplace(report.id, report.outcome->loss).second);
    EXPECT_EQ(report.worker, "a");
    EXPECT_EQ(report.attempt, 1);
    EXPECT_NEAR(report.compute_s, 0.02, 1e-9);
    EXPECT_GT(report.waited_s, last_waited_s + 0.0199);  // latencies differ by up to 0.1 ms
    last_waited_s = report.waited_s;
  });
  const auto outcomes = cluster.dispatcher->Evaluate(queries);
  ASSERT_EQ(losses.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(losses.at(cluster.dispatcher->CalcId(queries[i])), outcomes[i].loss);
}

TEST(DispatcherTest, EngineErrorEndsTheCallWithItsLine) {
  SimulatedCluster cluster(11, SimulatedCluster::MakeOptions(), {{"scenario.txt", "fail_at 7\n"}});
  cluster.StartWorker("a", 1000);
  auto queries = SimulatedCluster::MakeQueries(3);
  queries[1].variation = {7.0};
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(queries); }),
              AllOf(HasSubstr("this variation cannot be simulated"), HasSubstr("worker a")));
  queries.erase(queries.begin() + 1);
  ExpectRight(&cluster, queries);  // the dispatcher and the worker go on
}

TEST(DispatcherTest, ScenarioThatDoesNotLoadIsAnError) {
  SimulatedCluster cluster(12, SimulatedCluster::MakeOptions(), {{"scenario.txt", "colour 3\n"}});
  cluster.StartWorker("a", 1000);
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(1)); }),
              HasSubstr("unknown key 'colour'"));
}

TEST(DispatcherTest, NoWorkersIsAnErrorOfItsOwn) {
  SimulatedCluster cluster(13);
  EXPECT_THROW(cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(1)), NoWorkers);
  EXPECT_NEAR(cluster.now_s(), 30.0, 0.1);
}

TEST(DispatcherTest, StopFlagInterrupts) {
  SimulatedCluster cluster(14);
  cluster.StartWorker("a", SimulatedExecutor::kForever);
  std::atomic<bool> stop{false};
  cluster.dispatcher->set_stop_flag(&stop);
  cluster.network.Schedule(1'000'000, [&] { stop = true; });
  EXPECT_THROW(cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(3)), Interrupted);
  EXPECT_LT(cluster.now_s(), 1.1);
}

TEST(DispatcherTest, StuckWorkerLosesItsRequests) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 3.0;
  SimulatedCluster cluster(15, options);
  int stuck = 0;
  cluster.dispatcher->set_on_stalled([&](const KnownWorker& worker) {
    EXPECT_EQ(worker.name, "stuck");
    ++stuck;
  });
  cluster.StartWorker("stuck", SimulatedExecutor::kForever);  // its heart beats on
  cluster.network.Schedule(500'000, [&] { cluster.StartWorker("sound", 10'000); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(3));  // too few for a second copy
  EXPECT_EQ(stuck, 1);
  EXPECT_EQ(cluster.dispatcher->counters().workers_stalled, 1);
  EXPECT_EQ(cluster.dispatcher->counters().workers_lost, 0);
  EXPECT_LT(cluster.now_s(), 3.5);
}

TEST(DispatcherTest, RequestThatSticksEverywhereEndsTheRun) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 3.0;
  SimulatedCluster cluster(16, options);
  for (const char* name : {"a", "b", "c"}) cluster.StartWorker(name, SimulatedExecutor::kForever);
  const auto queries = SimulatedCluster::MakeQueries(1);
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(queries); }),
              AllOf(HasSubstr("no progress"), HasSubstr(FormatHex(cluster.dispatcher->CalcId(queries[0])))));
}

TEST(DispatcherTest, SlowButSteadyIsNotStuck) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 3.0;
  SimulatedCluster cluster(17, options);
  cluster.StartWorker("slow", 20'000'000);  // ten steps of two seconds
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(1));
  EXPECT_EQ(cluster.dispatcher->counters().workers_stalled, 0);
  EXPECT_EQ(cluster.dispatcher->counters().reissued, 0);
}

// Kills whoever computes the variation 666, and starts it again, as a spawner would.
void PlayAssassin(SimulatedCluster* cluster, DeathCause cause, int times, int* deaths) {
  cluster->dispatcher->set_on_pump([=] {
    if (*deaths >= times) return;
    const ContentId target = cluster->dispatcher->CalcId([] {
      RolloutQuery query = SimulatedCluster::MakeQueries(1)[0];
      query.variation = {666.0};
      return query;
    }());
    for (const auto& [instance, worker] : cluster->dispatcher->roster().workers()) {
      if (worker.running != target) continue;
      ++*deaths;
      const KnownWorker dead = worker;
      cluster->StartWorker(dead.name, 600'000);
      cluster->dispatcher->ReportDeath(dead.name, dead.pid, cause);
      return;
    }
  });
}

std::vector<RolloutQuery> MakeQueriesWithPoison() {
  auto queries = SimulatedCluster::MakeQueries(6);
  queries[3] = queries[0];
  queries[3].variation = {666.0};
  return queries;
}

TEST(DispatcherTest, RequestThatCrashesThreeWorkersIsPoison) {
  SimulatedCluster cluster(20);
  cluster.StartWorker("a", 600'000);  // longer than the status interval, so that the victim is seen
  cluster.StartWorker("b", 600'000);
  int deaths = 0;
  PlayAssassin(&cluster, DeathCause::kFault, 10, &deaths);
  const auto queries = MakeQueriesWithPoison();
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(queries); }),
              AllOf(HasSubstr("poison"), HasSubstr(FormatHex(cluster.dispatcher->CalcId(queries[3])))));
  EXPECT_EQ(deaths, 3);
}

TEST(DispatcherTest, KillsFromOutsideNeverMakePoison) {
  SimulatedCluster cluster(21);
  cluster.StartWorker("a", 600'000);  // longer than the status interval, so that the victim is seen
  cluster.StartWorker("b", 600'000);
  int deaths = 0;
  PlayAssassin(&cluster, DeathCause::kOutside, 5, &deaths);
  ExpectRight(&cluster, MakeQueriesWithPoison());
  EXPECT_EQ(deaths, 5);
}

TEST(DispatcherTest, PauseOfTheCoordinatorIsNobodysFault) {
  SimulatedCluster cluster(22);
  cluster.StartWorker("a", 1000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2));
  cluster.network.Advance(cluster.network.now_us() + 20'000'000, [] { return false; });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2, 50.0));
  EXPECT_EQ(cluster.dispatcher->counters().workers_lost, 0);
}

TEST(DispatcherTest, StrangersAreCountedAndIgnored) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.no_worker_s = 2.0;
  SimulatedCluster cluster(23, options);
  std::array<std::uint8_t, 32> other_key{1, 2, 3};
  const SimulatedWorker stranger(
      &cluster.network, &cluster.engine, "stranger", 5, [] { return 1000; }, RunKey(other_key));
  const auto voice = cluster.network.Connect({}, {});
  Sender sender(9, RunKey(), voice.get(), &cluster.network);
  worker_status_t status{};
  status.name = "future";
  status.engine = "closed-form";
  status.protocol = kProtocolVersion + 1;
  sender.Publish(kWorkerStatusChannel, 0, status);
  status.protocol = kProtocolVersion;
  status.engine = "other";
  sender.Publish(kWorkerStatusChannel, 0, status);
  sender.Publish(kWorkerStatusChannel, 0, control_t{});
  EXPECT_THROW(cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(1)), NoWorkers);
  const DispatchCounters& counters = cluster.dispatcher->counters();
  EXPECT_GE(counters.refused.corrupt, 8);
  EXPECT_EQ(counters.other_protocol, 1);
  EXPECT_EQ(counters.other_engine, 1);
  EXPECT_EQ(counters.refused.foreign, 1);
}

TEST(DispatcherTest, WorkersOfASilentRunServeTheNext) {
  SimulatedCluster cluster(24);
  cluster.StartWorker("a", 100'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2));
  // The first coordinator is gone without a word; a second one comes.
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.run_id = 78;
  cluster.dispatcher =
      std::make_unique<Dispatcher>(options, RunKey(), cluster.scenario, cluster.transport.get(), &cluster.network);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(2, 9.0));
  EXPECT_LT(cluster.now_s(), 4.0);
}

TEST(DispatcherTest, StopWorkersReachesAllDespiteLosses) {
  SimulatedCluster cluster(25);
  for (const char* name : {"a", "b", "c"}) cluster.StartWorker(name, 1000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(5));
  FaultRates faults;
  faults.drop = 0.5;
  cluster.network.set_faults(faults);
  cluster.dispatcher->StopWorkers(5.0);
  for (const auto& [name, worker] : cluster.workers) EXPECT_TRUE(worker->reactor().stopped()) << name;
}

TEST(DispatcherTest, RunStatusTellsTheRun) {
  SimulatedCluster cluster(26);
  cluster.StartWorker("a", 100'000);
  const auto watcher = cluster.network.Connect({std::string(kRunStatusChannel)}, {});
  RunProgress progress;
  progress.loss = 2.5;
  progress.theta = {1.0, 2.0};
  progress.method = "ours";
  cluster.dispatcher->SetProgress(progress);
  cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(30));
  int heard = 0;
  RefusalCounters refusals;
  std::optional<run_status_t> last;
  std::int64_t heard_us = 0;
  while (const auto message = watcher->Receive(0)) {
    const std::int64_t before_us = std::exchange(heard_us, message->arrival_us);
    EXPECT_TRUE(heard == 0 || heard_us - before_us <= 1'000'000);
    last = Open<run_status_t>(message->bytes, RunKey(), &refusals);
    ++heard;
  }
  EXPECT_GE(heard, 5);  // 3 s at 2 Hz
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->loss, 2.5);
  EXPECT_EQ(last->theta, progress.theta);
  EXPECT_EQ(last->method, "ours");
  EXPECT_EQ(last->workers, 1);
  EXPECT_GT(last->requests_done, 20);
  EXPECT_NEAR(last->rollouts_per_s, 10.0, 2.1);
}

TEST(DispatcherTest, OptionsAreChecked) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.credits = 17;
  EXPECT_THAT(CatchLine([&] { SimulatedCluster cluster(27, options); }),
              HasSubstr("credits is 17; 1 to 16 is allowed"));
}

}  // namespace dispatcher_test
}  // namespace knap
