// A dispatcher and any number of workers in simulated time, and what their answers must be.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "lcmtypes/wire/simulated_transport.h"
#include "tests/worker/closed_form_engine.h"
#include "tests/worker/simulated_worker.h"

namespace knap {

class SimulatedCluster {
 public:
  using Scenario = std::map<std::string, std::string>;

  static DispatchOptions MakeOptions() {
    DispatchOptions options;
    options.run_id = 77;
    options.engine = ClosedFormEngine().identity();
    return options;
  }

  explicit SimulatedCluster(std::uint64_t seed, const DispatchOptions& options = MakeOptions(),
                            Scenario scenario_files = {{"scenario.txt", "dimension 4\nsteps 10\n"}})
      : network(seed),
        scenario(std::move(scenario_files)),
        control_size(options.control_size),
        transport(network.Connect(Dispatcher::ListChannels(), {})),
        dispatcher(std::make_unique<Dispatcher>(options, RunKey(), scenario, transport.get(), &network)) {}

  // A worker whose requests take `duration_us` each. A second one of the same name replaces the first, which crashes.
  SimulatedWorker& StartWorker(const std::string& name, std::int64_t duration_us) {
    return StartWorker(
        name, [duration_us] { return duration_us; }, &engine);
  }
  SimulatedWorker& StartWorker(const std::string& name, std::function<std::int64_t()> duration_us, Engine* its_engine) {
    workers.erase(name);
    workers[name] = std::make_unique<SimulatedWorker>(&network, its_engine, name, ++instances, std::move(duration_us));
    return *workers[name];
  }
  void CrashWorker(const std::string& name) { workers.erase(name); }

  // For scenarios of dimension 4 with so many controls.
  static std::vector<RolloutQuery> MakeQueries(std::size_t count, double offset = 0.0, std::size_t controls = 0) {
    std::vector<RolloutQuery> queries(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = offset + static_cast<double>(i);
      queries[i].theta = {0.1 + x, 0.2 - 0.01 * x, 1.0 / (1.0 + x), 3.0};
      queries[i].variation = {0.013 * x, -0.7};
      if (i % 3 == 1) queries[i].theta_reference = {0.3, 0.1 * x, 0.7, 2.0};
      queries[i].gradient = i % 4 != 3;
      for (std::size_t k = 0; k < controls; ++k) {
        queries[i].theta.push_back(0.01 * static_cast<double>(k) - x);
        if (i % 3 == 1) queries[i].theta_reference.push_back(0.02 * static_cast<double>(k));
      }
    }
    return queries;
  }

  // The same queries answered without any cluster.
  std::vector<EngineAnswer> CalcExpected(const std::vector<RolloutQuery>& queries) {
    const std::unique_ptr<EngineScenario> loaded = engine.Load(scenario);
    std::vector<EngineAnswer> answers;
    for (const RolloutQuery& query : queries) {
      const auto design_end = query.theta.end() - static_cast<std::ptrdiff_t>(control_size);
      const EngineRequest request{.theta = {query.theta.begin(), design_end},
                                  .controls = {design_end, query.theta.end()},
                                  .reference = query.theta_reference,
                                  .variation = query.variation,
                                  .gradient = query.gradient};
      answers.push_back(loaded->Run(request, [](std::int64_t, std::int64_t) {}));
    }
    return answers;
  }

  double now_s() const { return static_cast<double>(network.now_us()) * 1e-6; }

  SimulatedNetwork network;
  Scenario scenario;
  std::size_t control_size;
  ClosedFormEngine engine;
  std::map<std::string, std::unique_ptr<SimulatedWorker>> workers;
  std::int64_t instances = 1000;
  std::unique_ptr<SimulatedTransport> transport;
  std::unique_ptr<Dispatcher> dispatcher;
};

// Evaluates, and expects each answer with the bits of one computed without any cluster.
inline void ExpectRight(SimulatedCluster* cluster, const std::vector<RolloutQuery>& queries) {
  const std::vector<EngineAnswer> expected = cluster->CalcExpected(queries);
  const std::vector<RolloutOutcome> outcomes = cluster->dispatcher->Evaluate(queries);
  ASSERT_EQ(outcomes.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(outcomes[i].loss, expected[i].loss) << i;
    EXPECT_EQ(outcomes[i].gradient, expected[i].gradient) << i;
    EXPECT_EQ(outcomes[i].success, expected[i].success) << i;
    EXPECT_EQ(outcomes[i].certificate.finite, true) << i;
    EXPECT_EQ(outcomes[i].certificate.worst_residual, expected[i].worst_residual) << i;
    EXPECT_EQ(outcomes[i].certificate.penetration, expected[i].penetration) << i;
    EXPECT_EQ(outcomes[i].certificate.largest_force, expected[i].largest_force) << i;
    EXPECT_EQ(outcomes[i].certificate.distrust, expected[i].distrust) << i;
  }
}

}  // namespace knap
