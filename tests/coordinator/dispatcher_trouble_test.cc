// What the dispatcher tells of requests that are given or sent again, and that it tells nothing where all goes well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <string>
#include <vector>

#include "tests/coordinator/simulated_cluster.h"

namespace knap {
namespace dispatcher_trouble_test {

class DispatcherTroubleTest : public ::testing::Test {
 protected:
  void Listen(SimulatedCluster* cluster) {
    cluster->dispatcher->set_on_trouble([this](const RequestTrouble& trouble) { troubles_.push_back(trouble); });
    cluster->dispatcher->set_on_result([this](const RolloutReport& report) { reports_.push_back(report); });
  }

  std::vector<RequestTrouble> Find(TroubleKind kind) const {
    std::vector<RequestTrouble> found;
    for (const RequestTrouble& trouble : troubles_) {
      if (trouble.kind == kind) found.push_back(trouble);
    }
    return found;
  }

  const RolloutReport* FindReport(const ContentId& id) const {
    for (const RolloutReport& report : reports_) {
      if (report.id == id) return &report;
    }
    return nullptr;
  }

  std::vector<RequestTrouble> troubles_;
  std::vector<RolloutReport> reports_;  // query and outcome are dead
};

TEST_F(DispatcherTroubleTest, ACalmRunTellsNothing) {
  SimulatedCluster cluster(50);
  Listen(&cluster);
  cluster.StartWorker("a", 50'000);
  cluster.StartWorker("b", 50'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(10));
  for (const RolloutReport& report : reports_) {
    EXPECT_GE(report.held_s, 0.05);
    EXPECT_LE(report.held_s, report.waited_s);
  }
  cluster.dispatcher->StopWorkers(5.0);  // and they say goodbye
  EXPECT_TRUE(troubles_.empty()) << GetName(troubles_.front().kind);
}

TEST_F(DispatcherTroubleTest, TheDeadAreNamedWithWhatTheyHeld) {
  for (const DeathCause cause : {DeathCause::kOutside, DeathCause::kFault}) {
    troubles_.clear();
    reports_.clear();
    SimulatedCluster cluster(51);
    Listen(&cluster);
    cluster.StartWorker("a", 200'000);
    cluster.StartWorker("b", 200'000);
    cluster.network.Schedule(300'000, [&] {
      cluster.CrashWorker("a");
      cluster.dispatcher->ReportDeath("a", 1001, cause);
    });
    ExpectRight(&cluster, SimulatedCluster::MakeQueries(6));
    const TroubleKind kind = cause == DeathCause::kFault ? TroubleKind::kFaulted : TroubleKind::kDied;
    ASSERT_EQ(Find(kind).size(), 1u);
    EXPECT_EQ(troubles_.size(), Find(kind).size() + Find(TroubleKind::kStraggler).size());
    const RequestTrouble death = Find(kind).front();
    EXPECT_EQ(death.worker, "a");
    EXPECT_EQ(death.host, "simulated");
    ASSERT_EQ(death.requests.size(), 2u);  // one ran, one waited
    for (const RequestTrouble::Held& held : death.requests) {
      EXPECT_EQ(held.attempt, 1);
      EXPECT_GT(held.held_s, 0.0);
      EXPECT_LE(held.held_s, 0.3);
      ASSERT_NE(FindReport(held.id), nullptr);
      EXPECT_EQ(FindReport(held.id)->worker, "b");
      EXPECT_EQ(FindReport(held.id)->attempt, 2);
    }
  }
}

TEST_F(DispatcherTroubleTest, WhoIsNotHeardIsNamedAndMayAnswerAllTheSame) {
  SimulatedCluster cluster(52);
  Listen(&cluster);
  SimulatedWorker& worker = cluster.StartWorker("a", 100'000);
  cluster.dispatcher->Pump(0.1);
  const std::int64_t now_us = cluster.network.now_us();
  cluster.network.Schedule(now_us + 50'000, [&] { worker.Freeze(); });
  cluster.network.Schedule(now_us + 2'000'000, [&] { worker.Thaw(); });
  const auto queries = SimulatedCluster::MakeQueries(1);
  ExpectRight(&cluster, queries);
  ASSERT_EQ(Find(TroubleKind::kSilent).size(), 1u);
  ASSERT_EQ(Find(TroubleKind::kSilent).front().requests.size(), 1u);
  EXPECT_EQ(Find(TroubleKind::kSilent).front().requests.front().id, cluster.dispatcher->CalcId(queries[0]));
}

TEST_F(DispatcherTroubleTest, WhoLeavesLacksOrSticksIsNamed) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.stall_s = 3.0;
  SimulatedCluster cluster(53, options);
  Listen(&cluster);
  cluster.StartWorker("stuck", SimulatedExecutor::kForever);
  cluster.StartWorker(
      "starved", [] { return SimulatedExecutor::kLacks; }, &cluster.engine);
  cluster.network.Schedule(500'000, [&] { cluster.StartWorker("sound", 10'000); });
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(3));
  ASSERT_EQ(Find(TroubleKind::kStuck).size(), 1u);
  EXPECT_EQ(Find(TroubleKind::kStuck).front().worker, "stuck");
  EXPECT_FALSE(Find(TroubleKind::kStuck).front().requests.empty());
  ASSERT_EQ(Find(TroubleKind::kLacking).size(), 1u);
  EXPECT_EQ(Find(TroubleKind::kLacking).front().worker, "starved");
  EXPECT_FALSE(Find(TroubleKind::kLacking).front().requests.empty());
}

TEST_F(DispatcherTroubleTest, ASecondCopyNamesBoth) {
  SimulatedCluster cluster(54);
  Listen(&cluster);
  bool is_first = true;
  cluster.StartWorker(
      "slow", [&is_first] { return std::exchange(is_first, false) ? 5'000'000 : 20'000; }, &cluster.engine);
  cluster.StartWorker("fast", 20'000);
  ExpectRight(&cluster, SimulatedCluster::MakeQueries(30));
  ASSERT_EQ(Find(TroubleKind::kStraggler).size(), 1u);
  const RequestTrouble copy = Find(TroubleKind::kStraggler).front();
  EXPECT_EQ(copy.worker, "slow");
  EXPECT_EQ(copy.helper, "fast");
  ASSERT_EQ(copy.requests.size(), 1u);
  EXPECT_EQ(copy.copy_attempt, copy.requests.front().attempt + 1);
  ASSERT_NE(FindReport(copy.requests.front().id), nullptr);
  EXPECT_EQ(FindReport(copy.requests.front().id)->worker, "fast");
  EXPECT_EQ(FindReport(copy.requests.front().id)->attempt, copy.copy_attempt);
}

TEST_F(DispatcherTroubleTest, LostMessagesAreTold) {
  SimulatedCluster cluster(55);
  Listen(&cluster);
  cluster.StartWorker("a", 100'000);
  cluster.dispatcher->Pump(0.1);
  FaultRates all_lost;
  all_lost.drop = 1.0;
  cluster.network.set_faults(all_lost);
  cluster.network.Schedule(cluster.network.now_us() + 150'000, [&] { cluster.network.set_faults(FaultRates()); });
  const auto queries = SimulatedCluster::MakeQueries(1);
  ExpectRight(&cluster, queries);
  std::int64_t resent = 0;
  for (const RequestTrouble& trouble : Find(TroubleKind::kMessageLost)) {
    EXPECT_EQ(trouble.worker, "a");
    ASSERT_EQ(trouble.requests.size(), 1u);
    EXPECT_EQ(trouble.requests.front().id, cluster.dispatcher->CalcId(queries[0]));
    EXPECT_EQ(trouble.requests.front().attempt, 1);
    ++resent;
  }
  EXPECT_GE(resent, 1);
  EXPECT_EQ(resent, cluster.dispatcher->counters().resent);
  EXPECT_EQ(reports_.at(0).attempt, 1);  // sent again is not given again
}

TEST_F(DispatcherTroubleTest, WhatIsOpenWhenTheCallEndsIsTold) {
  SimulatedCluster cluster(56);
  Listen(&cluster);
  cluster.StartWorker("a", SimulatedExecutor::kForever);
  std::atomic<bool> stop{false};
  cluster.dispatcher->set_stop_flag(&stop);
  cluster.network.Schedule(1'000'000, [&] { stop = true; });
  const auto queries = SimulatedCluster::MakeQueries(5);
  EXPECT_THROW(cluster.dispatcher->Evaluate(queries), Interrupted);
  std::set<ContentId> held, waiting;
  for (const RequestTrouble& trouble : Find(TroubleKind::kDropped)) {
    for (const RequestTrouble::Held& request : trouble.requests) {
      (trouble.worker.empty() ? waiting : held).insert(request.id);
      EXPECT_EQ(request.attempt, trouble.worker.empty() ? 0 : 1);
    }
  }
  EXPECT_EQ(held.size(), 2u);
  EXPECT_EQ(waiting.size(), 3u);
}

}  // namespace dispatcher_trouble_test
}  // namespace knap
