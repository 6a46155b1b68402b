// What the cluster costs: knap-cluster-benchmark [NAME…], all of them without a name. Real processes, real LCM, real
// journal; figures belong to the machine and its other load, so they are printed, never judged.
//
//   requests     trivial requests a second, and the coordinator's processor time for each, with 2 and with 64 workers
//   efficiency   rollouts a second of one worker a core, over (rollouts a second in one thread) × cores, at 10 ms each;
//                the same of one thread a core tells what the machine allows
//   reissue      from kill -9 of a worker to another worker's getting its request: found by silence, or told by the
//                parent process
//   first        from the start of `knap learn` to its first answer
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "coordinator/local_workers.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/lcm_transport.h"
#include "lcmtypes/wire/multicast.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/cluster/child_process.h"
#include "tests/worker/closed_form_engine.h"
#include "worker/knap_engine.h"
#include "worker/knap_identity.h"

namespace knap {
namespace {

// Of all threads of this process [s].
double ReadProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double CalcMedian(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// A coordinator as `knap learn` has it, with workers of its own.
class BenchmarkCluster {
 public:
  BenchmarkCluster(int workers, const std::string& program, const EngineIdentity& engine, const ScenarioFiles& scenario,
                   bool reports_deaths = true)
      : journal_(Journal::Create(folder_ / "journal", {{"engine", engine.name}})),
        transport_(url_, Dispatcher::ListChannels(), &clock_) {
    const RunKey key = RunKey::MakeRandom();
    key.WriteFile(folder_ / "key");
    DispatchOptions options;
    options.run_id = getpid();
    options.engine = engine;
    dispatcher_ = std::make_unique<Dispatcher>(options, key, scenario, &transport_, &clock_);
    service_ = std::make_unique<JournaledService>(dispatcher_.get(), &journal_, std::vector<std::string>());
    workers_ = std::make_unique<LocalWorkers>(
        LocalWorkerOptions{workers, FindWorkerProgram(program), url_, folder_ / "key", folder_ / ""}, &clock_,
        [this, reports_deaths](const std::string& name, pid_t pid, DeathCause cause) {
          if (reports_deaths) dispatcher_->ReportDeath(name, pid, cause);
        });
    dispatcher_->set_on_pump([this] {
      workers_->Poll();
      if (on_pump) on_pump();
    });
    while (dispatcher_->CountUsableWorkers() < workers) dispatcher_->Pump(0.01);
  }

  std::function<void()> on_pump;
  JournaledService& service() { return *service_; }
  Dispatcher& dispatcher() { return *dispatcher_; }
  LocalWorkers& workers() { return *workers_; }

 private:
  TemporaryFolder folder_;
  const std::string url_ = MakeFreeLcmUrl();
  SteadyClock clock_;
  Journal journal_;
  LcmTransport transport_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<JournaledService> service_;
  std::unique_ptr<LocalWorkers> workers_;
};

std::vector<RolloutQuery> MakeTrivialQueries(int count, double first) {
  std::vector<RolloutQuery> queries(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < queries.size(); ++i) {
    queries[i].theta = std::vector<double>(7, first + static_cast<double>(i));
    queries[i].variation = {0.25, 0.5};
  }
  return queries;
}

void MeasureRequests() {
  constexpr int kBatch = 5000, kBatches = 8;
  for (const int workers : {2, 64}) {
    BenchmarkCluster cluster(workers, "knap-test-worker", ClosedFormEngine().identity(),
                             {{"scenario.txt", "dimension 7\nsteps 1\n"}});
    cluster.service().Evaluate(MakeTrivialQueries(kBatch, -1e6));  // from here on it knows how short they are
    std::vector<double> rates, costs;
    for (int batch = 0; batch < kBatches; ++batch) {
      const std::vector<RolloutQuery> queries = MakeTrivialQueries(kBatch, batch * kBatch);
      const double start = ReadSteadySeconds(), processor = ReadProcessorTime();
      cluster.service().Evaluate(queries);
      rates.push_back(kBatch / (ReadSteadySeconds() - start));
      costs.push_back((ReadProcessorTime() - processor) / kBatch);
    }
    const DispatchCounters& counters = cluster.dispatcher().counters();
    fmt::print(
        "requests    {:2} workers: {:6.0f} a second (best {:.0f}), coordinator {:.1f} us each (worst {:.1f}); "
        "{} resent, {} moved, {} copied\n",
        workers, CalcMedian(rates), *std::max_element(rates.begin(), rates.end()), 1e6 * CalcMedian(costs),
        1e6 * *std::max_element(costs.begin(), costs.end()), counters.resent, counters.moved, counters.copied);
  }
}

// Answers every query in this process, on as many threads as there are engines; the seconds that it takes.
double RunInProcess(const std::vector<RolloutQuery>& queries,
                    const std::vector<std::unique_ptr<EngineScenario>>& engines) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&](EngineScenario* engine) {
    for (std::size_t i = next++; i < queries.size(); i = next++) {
      const RolloutQuery& query = queries[i];
      const EngineAnswer answer =
          engine->Run({query.theta, {}, {}, query.variation, true}, [](std::int64_t, std::int64_t) {});
      if (!answer.error.empty()) throw std::runtime_error(answer.error);
    }
  };
  const double start = ReadSteadySeconds();
  std::vector<std::future<void>> threads;
  for (const auto& engine : engines) threads.push_back(std::async(std::launch::async, work, engine.get()));
  for (std::future<void>& thread : threads) thread.get();
  return ReadSteadySeconds() - start;
}

void MeasureEfficiency() {
  constexpr int kBatch = 200, kRounds = 21;
  const std::vector<std::string> overrides = {"rollout.horizon=3.8 s"};
  const LoadedScenario scenario = LoadScenario(KNAP_SOURCE_DIR "/configs/pushing.yaml", overrides);
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  BenchmarkCluster cluster(cores, "knap-worker", MakeOwnIdentity(kKnapEngine, FindWorkerProgram()), scenario.files);
  std::vector<std::unique_ptr<EngineScenario>> one, many;
  one.push_back(MakeKnapEngine()->Load(scenario.files));
  for (int i = 0; i < cores; ++i) many.push_back(MakeKnapEngine()->Load(scenario.files));
  std::vector<double> theta;
  for (const DesignParameter& parameter : scenario.parsed.scene.design->parameters) theta.push_back(parameter.initial);
  std::vector<double> efficiencies, limits, shares, times;
  for (int round = -1; round < kRounds; ++round) {  // the first one fills caches and does not count
    std::vector<RolloutQuery> queries(kBatch);
    for (int i = 0; i < kBatch; ++i) {
      const double turn = 0.1 * (i + 1 + kBatch * (round + 1));  // never asked before
      queries[static_cast<std::size_t>(i)] = {theta, {}, {0.04 * std::sin(turn), 0.1 + 0.02 * std::cos(turn)}, true};
    }
    const double alone_s = RunInProcess(queries, one);
    const double start = ReadSteadySeconds();
    cluster.service().Evaluate(queries);
    const double cluster_s = ReadSteadySeconds() - start;
    const double threads_s = RunInProcess(queries, many);
    if (round < 0) continue;
    efficiencies.push_back(alone_s / (cores * cluster_s));
    limits.push_back(alone_s / (cores * threads_s));
    shares.push_back(threads_s / cluster_s);
    times.push_back(alone_s / kBatch);
  }
  const auto format_range = [](const std::vector<double>& x) {
    return fmt::format("{:.3f} (from {:.3f} to {:.3f})", CalcMedian(x), *std::min_element(x.begin(), x.end()),
                       *std::max_element(x.begin(), x.end()));
  };
  fmt::print(
      "efficiency  {} workers, rollouts of {:.1f} ms: {}; as many threads of one process: {}; the cluster over those: "
      "{}; {} rounds\n",
      cores, 1e3 * CalcMedian(times), format_range(efficiencies), format_range(limits), format_range(shares), kRounds);
}

void MeasureReissue() {
  constexpr int kTrials = 10;
  for (const bool reports_deaths : {false, true}) {
    // Four requests of 1.5 s for two workers: both are at work, and each has one waiting.
    BenchmarkCluster cluster(2, "knap-test-worker", ClosedFormEngine().identity(),
                             {{"scenario.txt", "dimension 7\nsteps 100\nstep_us 15000\n"}}, reports_deaths);
    std::vector<double> times;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double start = ReadSteadySeconds();
      const std::int64_t reissued = cluster.dispatcher().counters().reissued;
      double killed = 0.0, found = 0.0;
      cluster.on_pump = [&] {
        if (killed == 0.0 && ReadSteadySeconds() - start > 0.3 + 0.05 * trial) {
          kill(cluster.workers().ListProcesses().front(), SIGKILL);
          killed = ReadSteadySeconds();
        }
        if (found == 0.0 && cluster.dispatcher().counters().reissued > reissued) found = ReadSteadySeconds();
      };
      cluster.service().Evaluate(MakeTrivialQueries(4, 10.0 * trial));
      cluster.on_pump = {};
      times.push_back(found - killed);
      while (cluster.dispatcher().CountUsableWorkers() < 2) cluster.dispatcher().Pump(0.01);
    }
    fmt::print("reissue     {}: {:.2f} s (at most {:.2f} in {} kills)\n",
               reports_deaths ? "told by the parent process" : "found by silence          ", CalcMedian(times),
               *std::max_element(times.begin(), times.end()), kTrials);
  }
}

void MeasureFirstAnswer() {
  constexpr int kTrials = 10;
  TemporaryFolder folder;
  std::vector<double> times;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::string out = fmt::format("run-{}", trial);
    const std::filesystem::path answers = folder / (out + "/rollouts.csv");
    const double start = ReadSteadySeconds();
    ChildProcess learn(FindWorkerProgram("knap"),
                       {"learn", KNAP_SOURCE_DIR "/configs/pushing.yaml", "--out", out, "--quiet"}, folder / "", "log");
    const auto has_answer = [&] {
      const std::string text = ReadText(answers);
      return std::count(text.begin(), text.end(), '\n') >= 2;  // names, and one answer
    };
    while (!has_answer()) {
      if (learn.HasEnded()) throw std::runtime_error("knap learn ended: " + learn.ReadErr());
      usleep(2000);
    }
    times.push_back(ReadSteadySeconds() - start);
    learn.Signal(SIGINT);
    learn.Wait();
  }
  fmt::print("first       answer of knap learn configs/pushing.yaml: {:.2f} s (at most {:.2f} in {} starts)\n",
             CalcMedian(times), *std::max_element(times.begin(), times.end()), kTrials);
}

}  // namespace
}  // namespace knap

int main(int argc, char** argv) {
  const std::vector<std::pair<std::string, void (*)()>> all = {{"requests", knap::MeasureRequests},
                                                               {"efficiency", knap::MeasureEfficiency},
                                                               {"reissue", knap::MeasureReissue},
                                                               {"first", knap::MeasureFirstAnswer}};
  const std::vector<std::string> wanted(argv + 1, argv + argc);
  try {
    for (const auto& [name, measure] : all) {
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) measure();
      std::fflush(stdout);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "knap-cluster-benchmark: {}\n", e.what());
    return 1;
  }
}
