// Workers compared with each other: second copies, answers that differ, and who is let in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/coordinator/simulated_cluster.h"
#include "tests/support/catch_line.h"

namespace knap {
namespace dispatcher_trust_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(DispatcherTrustTest, StragglerIsComputedASecondTimeOnAnIdleWorker) {
  SimulatedCluster cluster(30);
  cluster.StartWorker("slow", 20'000'000);
  cluster.StartWorker("fast", 50'000);
  cluster.dispatcher->Pump(0.1);
  const double begin_s = cluster.now_s();
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(8));
  EXPECT_EQ(cluster.dispatcher->counters().copied, 1);
  EXPECT_EQ(cluster.dispatcher->counters().reissued, 0);
  // Seven rounds of 50 ms on the fast one, then the copy; alone the slow one would take 20 s.
  EXPECT_LT(cluster.now_s() - begin_s, 0.5);
  // Its own answer comes late, agrees, and is acknowledged.
  cluster.dispatcher->Pump(21.0);
  EXPECT_GE(cluster.dispatcher->counters().duplicates, 1);
}

TEST(DispatcherTrustTest, NoSecondCopyBeforeThreeQuartersAreDone) {
  SimulatedCluster cluster(31);
  cluster.StartWorker("slow", 1'000'000);
  cluster.StartWorker("fast", 50'000);
  cluster.dispatcher->Pump(0.1);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(3));  // two of three are done when the slow one computes alone
  EXPECT_EQ(cluster.dispatcher->counters().copied, 0);
}

TEST(DispatcherTrustTest, NoSecondCopyOfWhatTakesItsUsualTime) {
  SimulatedCluster cluster(32);
  for (const char* name : {"a", "b", "c"}) cluster.StartWorker(name, 500'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(16));  // at the end one computes and two are idle
  EXPECT_EQ(cluster.dispatcher->counters().copied, 0);
}

TEST(DispatcherTrustTest, WorkersOfAnotherBuildOrWithOtherBitsAreRefusedByName) {
  SimulatedCluster cluster(36);
  EngineIdentity other_build = cluster.engine.identity(), other_bits = other_build;
  other_build.build = std::string("2");
  other_bits.fingerprint = CalcFingerprint(std::vector<double>{0.5000000000000001});
  WrongEngine newer(other_build), rounding(other_bits);
  cluster.StartWorker(
      "newer", [] { return std::int64_t{1000}; }, &newer);
  cluster.StartWorker(
      "rounding", [] { return std::int64_t{1000}; }, &rounding);
  EXPECT_THAT(CatchLine([&] { cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(3)); }),
              AllOf(HasSubstr("no worker"), HasSubstr("worker newer on simulated"), HasSubstr("build '2'"),
                    HasSubstr("worker rounding on simulated"), HasSubstr("other bits")));
  EXPECT_EQ(cluster.dispatcher->counters().workers_refused, 2);
  cluster.StartWorker("right", 1000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(6));
  EXPECT_EQ(cluster.dispatcher->counters().workers_refused, 2);  // they go on announcing themselves; once is enough
}

TEST(DispatcherTrustTest, CopyThatDisagreesStopsTheRunAndNamesBoth) {
  SimulatedCluster cluster(37);
  WrongEngine wrong;
  cluster.StartWorker(
      "slow", [] { return std::int64_t{600'000}; }, &wrong);
  cluster.StartWorker("fast", 50'000);
  cluster.dispatcher->Pump(0.1);
  const std::string line = CatchLine([&] {
    // Three quarters come from the fast one; its copy of the last is the first answer, then comes the slow one's.
    cluster.dispatcher->Evaluate(SimulatedCluster::MakeQueries(8));
    cluster.dispatcher->Pump(2.0);
  });
  EXPECT_EQ(cluster.dispatcher->counters().copied, 1);
  EXPECT_THAT(line, AllOf(HasSubstr("disagree"), HasSubstr("worker slow"), HasSubstr("worker fast")));
}

// One step that takes longer than the stall time: the request is given to the second worker, and both answer.
void RunTwice(SimulatedCluster* cluster, Engine* second_engine) {
  cluster->StartWorker("first", 3'000'000);
  cluster->network.Schedule(1'000'000, [=] {
    cluster->StartWorker(
        "second", [] { return std::int64_t{3'500'000}; }, second_engine);
  });
  cluster->dispatcher->Evaluate(SimulatedCluster::MakeQueries(1));
  cluster->dispatcher->Pump(5.0);
}

TEST(DispatcherTrustTest, TwoEqualAnswersAreFine) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 1.5;
  SimulatedCluster cluster(18, options, {{"scenario.txt", "dimension 4\nsteps 1\n"}});
  RunTwice(&cluster, &cluster.engine);
  EXPECT_EQ(cluster.dispatcher->counters().reissued, 1);
  EXPECT_EQ(cluster.dispatcher->counters().duplicates, 1);
}

TEST(DispatcherTrustTest, TwoDifferentAnswersStopTheRun) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 1.5;
  SimulatedCluster cluster(19, options, {{"scenario.txt", "dimension 4\nsteps 1\n"}});
  WrongEngine wrong;
  EXPECT_THAT(CatchLine([&] { RunTwice(&cluster, &wrong); }),
              AllOf(HasSubstr("disagree"), HasSubstr("worker second"), HasSubstr("worker first"), HasSubstr("loss")));
}

}  // namespace dispatcher_trust_test
}  // namespace knap
