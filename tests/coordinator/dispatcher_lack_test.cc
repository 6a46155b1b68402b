// Workers that lack something, and workers that do not hear: their trouble, and no answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/coordinator/simulated_cluster.h"

namespace knap {
namespace dispatcher_lack_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Starts a worker that lacks memory for whatever it computes, and starts it again 0.1 s after each end.
void StartStarved(SimulatedCluster* cluster, const std::string& name) {
  cluster->StartWorker(
      name, [] { return SimulatedExecutor::kLacks; }, &cluster->engine);
  cluster->network.Schedule(cluster->network.now_us() + 100'000, [cluster, name] {
    if (cluster->now_s() < 60.0) StartStarved(cluster, name);
  });
}

TEST(DispatcherLackTest, AStarvedWorkerAmongHealthyOnesChangesNothing) {
  SimulatedCluster cluster(40);
  StartStarved(&cluster, "starved");
  for (const char* name : {"a", "b"}) cluster.StartWorker(name, 50'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(30));
  const DispatchCounters& counters = cluster.dispatcher->counters();
  EXPECT_GT(counters.workers_lacking, 0);
  EXPECT_EQ(counters.computed, 30);
  EXPECT_THAT(cluster.dispatcher->lacking().begin()->second,
              AllOf(HasSubstr("starved"), HasSubstr("simulated"), HasSubstr("out of memory")));
}

TEST(DispatcherLackTest, WhatEveryWorkerLacksSomethingForEndsTheRunWithTheReason) {
  SimulatedCluster cluster(41);
  for (const char* name : {"a", "b"}) StartStarved(&cluster, name);
  try {
    cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(1));
    FAIL() << "nothing was thrown";
  } catch (const NoWorkers& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("no worker that has what request"), HasSubstr("worker a on simulated left: "),
                                HasSubstr("worker b on simulated left: out of memory")));
  }
  EXPECT_EQ(cluster.dispatcher->counters().workers_lacking, 2);  // each tried it once, though both came again
  EXPECT_LT(cluster.now_s(), 32.0);
}

// It is heard, and hears nothing: what it was given goes to nobody for want of another worker, and it is no stuck
// request. When it hears again it gets work again, though its own state never changed.
TEST(DispatcherLackTest, ADeafWorkerGetsWorkAgain) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 2.0;
  SimulatedCluster cluster(42, options);
  const SimulatedWorker& worker = cluster.StartWorker("a", 10'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(1));
  const int coordinator = cluster.transport->address(), deaf = worker.address();
  cluster.network.Cut(coordinator, deaf);
  cluster.network.Schedule(cluster.network.now_us() + 5'000'000, [&] { cluster.network.Mend(coordinator, deaf); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(3, 10.0));
  EXPECT_GT(cluster.dispatcher->counters().workers_stalled, 0);
  EXPECT_LT(cluster.now_s(), 10.0);
}

TEST(DispatcherLackTest, WhatNeverArrivedDidNotGetStuck) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 1.0;
  SimulatedCluster cluster(43, options);
  const int coordinator = cluster.transport->address();
  for (const char* name : {"a", "b", "c", "d"}) {
    const int deaf = cluster.StartWorker(name, 10'000).address();
    cluster.network.Schedule(200'000, [&, deaf] { cluster.network.Cut(coordinator, deaf); });
    cluster.network.Schedule(12'000'000, [&, deaf] { cluster.network.Mend(coordinator, deaf); });
  }
  cluster.dispatcher->Pump(1.0);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(1));  // given to each of them in turn
  EXPECT_GE(cluster.dispatcher->counters().workers_stalled, 3);
}

}  // namespace dispatcher_lack_test
}  // namespace knap
