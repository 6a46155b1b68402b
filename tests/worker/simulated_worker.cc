#include "tests/worker/simulated_worker.h"

#include <algorithm>
#include <utility>

namespace knap {

void SimulatedExecutor::Start(ExecutorJob job) {
  steps_ = 0;
  answer_ = runner_.Run(job, [this](std::int64_t, std::int64_t total) { steps_ = total; });
  start_us_ = clock_->now_us();
  duration_us_ = job.request ? draw_duration_us_() : 0;
  if (duration_us_ != kLacks) return;
  duration_us_ = 0;
  answer_ = EngineAnswer{};
  answer_->lack = "out of memory";
}

std::optional<EngineAnswer> SimulatedExecutor::TakeAnswer() {
  const std::optional<std::int64_t> end_us = FindEnd();
  if (!end_us || clock_->now_us() < *end_us) return std::nullopt;
  return std::exchange(answer_, std::nullopt);
}

StepProgress SimulatedExecutor::progress() const {
  if (duration_us_ <= 0) return {steps_ / 2, steps_};
  return {steps_ * std::min(clock_->now_us() - start_us_, duration_us_) / duration_us_, steps_};
}

std::optional<std::int64_t> SimulatedExecutor::FindEnd() const {
  if (!answer_ || duration_us_ == kForever) return std::nullopt;
  return start_us_ + duration_us_;
}

SimulatedWorker::SimulatedWorker(SimulatedNetwork* network, Engine* engine, const std::string& name,
                                 std::int64_t instance, std::function<std::int64_t()> draw_duration_us,
                                 const RunKey& key)
    : network_(network),
      transport_(network->Connect(WorkerReactor::ListChannels(name), [this] { Step(); })),
      executor_(engine, network, std::move(draw_duration_us)) {
  reactor_ = std::make_unique<WorkerReactor>(
      WorkerIdentity{name, instance, engine->identity(), "simulated", static_cast<std::int32_t>(instance % 100000)},
      key, transport_.get(), network, &executor_);
  Step();
}

void SimulatedWorker::Thaw() {
  frozen_ = false;
  Step();
}

void SimulatedWorker::Step() {
  if (frozen_ || reactor_->stopped()) return;
  for (std::optional<Message> message = transport_->Receive(0); message; message = transport_->Receive(0)) {
    reactor_->Handle(*message);
  }
  reactor_->Tick();
  std::int64_t wake_us = reactor_->next_deadline_us();
  if (const std::optional<std::int64_t> end_us = executor_.FindEnd()) wake_us = std::min(wake_us, *end_us);
  if (wake_us == wake_us_) return;
  wake_us_ = wake_us;
  network_->Schedule(wake_us, [this, life = std::weak_ptr<int>(life_), wake_us] {
    // Only the latest wake-up counts: an earlier one has been replaced.
    if (life.expired() || wake_us != wake_us_) return;
    wake_us_ = -1;
    Step();
  });
}

}  // namespace knap
