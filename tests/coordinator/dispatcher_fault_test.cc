// Random schedules of network faults and worker crashes: every answer arrives, and arrives with the right bits.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/coordinator/simulated_cluster.h"

namespace knap {
namespace dispatcher_fault_test {

constexpr int kSchedules = 300;
constexpr double kTimeLimitS = 600.0;  // simulated; the work itself takes a few seconds

std::string MakeName(int i) { return std::string("w").append(std::to_string(i)); }

// Kills and restarts a random worker at random instants, for as long as the cluster lives.
void ScheduleCrashes(SimulatedCluster* cluster, int worker_count, double mean_interval_s) {
  SimulatedNetwork& network = cluster->network;
  const auto after = [&network](double seconds) { return network.now_us() + static_cast<std::int64_t>(seconds * 1e6); };
  network.Schedule(after(2.0 * mean_interval_s * network.DrawUniform()), [=, &network] {
    const std::string name = MakeName(static_cast<int>(worker_count * network.DrawUniform()));
    cluster->CrashWorker(name);
    network.Schedule(after(1.5 * network.DrawUniform()), [=, &network] {
      cluster->StartWorker(
          name, [&network] { return static_cast<std::int64_t>(1e3 + 3e5 * network.DrawUniform()); }, &cluster->engine);
    });
    ScheduleCrashes(cluster, worker_count, mean_interval_s);
  });
}

void RunSchedule(std::uint64_t seed, std::size_t controls, DispatchCounters* sum) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  // A scenario of several pieces, so that fetching it meets faults too.
  const std::string scenario = "dimension 4\nsteps 10\ncontrols " + std::to_string(controls) + "\n";
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.control_size = controls;
  SimulatedCluster cluster(seed, options, {{"scenario.txt", scenario}, {"mesh.obj", std::string(5000, 'v')}});
  SimulatedNetwork& network = cluster.network;
  FaultRates faults;
  faults.drop = 0.3 * network.DrawUniform();
  faults.duplicate = 0.3 * network.DrawUniform();
  faults.delay = 0.3 * network.DrawUniform();
  faults.corrupt = 0.2 * network.DrawUniform();
  network.set_faults(faults);
  const int worker_count = 1 + static_cast<int>(4 * network.DrawUniform());
  for (int i = 0; i < worker_count; ++i) {
    cluster.StartWorker(
        MakeName(i), [&network] { return static_cast<std::int64_t>(1e3 + 3e5 * network.DrawUniform()); },
        &cluster.engine);
  }
  ScheduleCrashes(&cluster, worker_count, 0.5 + 4.0 * network.DrawUniform());
  cluster.dispatcher->set_on_pump([&] {
    if (cluster.now_s() > kTimeLimitS) throw std::runtime_error("answers are missing when the time is over");
  });

  for (int call = 0; call < 3; ++call) {
    auto queries = SimulatedCluster::MakeQueries(7, 10.0 * call, controls);
    const auto repeated = SimulatedCluster::MakeQueries(2, 0.0, controls);
    queries.insert(queries.end(), repeated.begin(), repeated.end());
    const auto expected = cluster.CalcExpected(queries);
    std::vector<RolloutOutcome> outcomes;
    ASSERT_NO_THROW(outcomes = cluster.dispatcher->Evaluate(queries));
    ASSERT_EQ(outcomes.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(outcomes[i].loss, expected[i].loss);
      EXPECT_EQ(outcomes[i].success, expected[i].success);
      EXPECT_EQ(outcomes[i].gradient, expected[i].gradient);
      EXPECT_EQ(outcomes[i].steps, expected[i].steps);
    }
  }
  cluster.dispatcher->set_on_pump({});
  const DispatchCounters& counters = cluster.dispatcher->counters();
  EXPECT_EQ(counters.requested, 27);
  EXPECT_EQ(counters.remembered, 6);
  EXPECT_EQ(counters.computed, 21);
  sum->reissued += counters.reissued;
  sum->resent += counters.resent;
  sum->duplicates += counters.duplicates;
  sum->workers_lost += counters.workers_lost;
  sum->refused.corrupt += counters.refused.corrupt;
}

TEST(DispatcherFaultTest, EveryAnswerArrivesWithTheRightBits) {
  DispatchCounters sum;
  for (std::uint64_t seed = 1; seed <= kSchedules && !HasFailure(); ++seed) RunSchedule(seed, 0, &sum);
  // The schedules are worth something only if all this happened, and often.
  EXPECT_GT(sum.reissued, kSchedules);
  EXPECT_GT(sum.resent, kSchedules);
  EXPECT_GT(sum.duplicates, kSchedules);
  EXPECT_GT(sum.workers_lost, kSchedules);
  EXPECT_GT(sum.refused.corrupt, kSchedules);
}

// Requests of up to 250 values and answers of 124: three parts and two, of which any may be lost.
TEST(DispatcherFaultTest, ControlsArriveInParts) {
  DispatchCounters sum;
  for (std::uint64_t seed = 1001; seed <= 1000 + kSchedules / 3 && !HasFailure(); ++seed) RunSchedule(seed, 120, &sum);
  EXPECT_GT(sum.resent, kSchedules / 3);
  EXPECT_GT(sum.refused.corrupt, kSchedules / 3);
}

// As many values as a policy has weights: 100 messages for a request and 50 for its answer. On a network that loses one
// message in ten a whole request never arrives at once; what is sent again fills the gaps.
TEST(DispatcherFaultTest, LargeRequestsNeedOnlyTheirMissingParts) {
  DispatchOptions options = SimulatedCluster::MakeOptions();
  options.control_size = 4796;
  SimulatedCluster cluster(2001, options, {{"scenario.txt", "dimension 4\nsteps 10\ncontrols 4796\n"}});
  FaultRates faults;
  faults.drop = 0.1;
  cluster.network.set_faults(faults);
  cluster.StartWorker("a", 10'000);
  cluster.StartWorker("b", 10'000);
  const auto queries = SimulatedCluster::MakeQueries(6, 0.0, 4796);
  const auto expected = cluster.CalcExpected(queries);
  const auto outcomes = cluster.dispatcher->Evaluate(queries);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(outcomes[i].loss, expected[i].loss);
    EXPECT_EQ(outcomes[i].gradient, expected[i].gradient);
  }
  EXPECT_LT(cluster.now_s(), 10.0);
}

}  // namespace dispatcher_fault_test
}  // namespace knap
