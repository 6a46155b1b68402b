// A worker in simulated time: the real reactor on the simulated network, with an executor whose jobs take as much
// simulated time as it is told.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "lcmtypes/wire/simulated_transport.h"
#include "worker/job_runner.h"
#include "worker/worker_reactor.h"

namespace knap {

// Computes at once and hands the answer out when its time has passed; a job that never ends takes kForever.
class SimulatedExecutor : public Executor {
 public:
  static constexpr std::int64_t kForever = -1;
  static constexpr std::int64_t kLacks = -2;  // no duration: the computation finds at once that memory lacks

  // `draw_duration_us` is asked once a request; loading takes no time.
  SimulatedExecutor(Engine* engine, const Clock* clock, std::function<std::int64_t()> draw_duration_us)
      : runner_(engine), clock_(clock), draw_duration_us_(std::move(draw_duration_us)) {}

  void Start(ExecutorJob job) override;
  bool busy() const override { return answer_.has_value(); }
  std::optional<EngineAnswer> TakeAnswer() override;
  StepProgress progress() const override;

  // When the running job ends; empty when nothing runs or it never ends.
  std::optional<std::int64_t> FindEnd() const;

 private:
  JobRunner runner_;
  const Clock* clock_;
  std::function<std::int64_t()> draw_duration_us_;
  std::int64_t start_us_ = 0;
  std::int64_t duration_us_ = 0;
  std::int64_t steps_ = 0;
  std::optional<EngineAnswer> answer_;
};

class SimulatedWorker {
 public:
  // Joins the network at once; its destruction is a crash: nobody is told.
  SimulatedWorker(SimulatedNetwork* network, Engine* engine, const std::string& name, std::int64_t instance,
                  std::function<std::int64_t()> draw_duration_us, const RunKey& key = RunKey());

  const WorkerReactor& reactor() const { return *reactor_; }
  int address() const { return transport_->address(); }  // for SimulatedNetwork::Cut

  // As SIGSTOP and SIGCONT: messages wait, and nothing is said. Its computation ends when it would have ended.
  void Freeze() { frozen_ = true; }
  void Thaw();

 private:
  void Step();

  bool frozen_ = false;
  SimulatedNetwork* network_;
  std::shared_ptr<int> life_ = std::make_shared<int>(0);  // events of the dead do nothing
  std::int64_t wake_us_ = -1;                             // the latest wake-up asked for
  std::unique_ptr<SimulatedTransport> transport_;
  SimulatedExecutor executor_;
  std::unique_ptr<WorkerReactor> reactor_;
};

}  // namespace knap
