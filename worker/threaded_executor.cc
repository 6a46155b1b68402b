#include "worker/threaded_executor.h"

#include <utility>

namespace knap {

ThreadedExecutor::ThreadedExecutor(Engine* engine, std::function<void()> on_finished)
    : runner_(engine), on_finished_(std::move(on_finished)), thread_([this] { RunJobs(); }) {}

ThreadedExecutor::~ThreadedExecutor() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void ThreadedExecutor::Start(ExecutorJob job) {
  busy_ = true;
  steps_done_ = 0;
  steps_total_ = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    job_ = std::move(job);
  }
  changed_.notify_one();
}

std::optional<EngineAnswer> ThreadedExecutor::TakeAnswer() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!answer_) return std::nullopt;
  busy_ = false;
  return std::exchange(answer_, std::nullopt);
}

StepProgress ThreadedExecutor::progress() const { return {steps_done_, steps_total_}; }

void ThreadedExecutor::RunJobs() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return job_.has_value() || stopping_; });
    if (stopping_) return;
    const ExecutorJob job = *std::exchange(job_, std::nullopt);
    lock.unlock();
    EngineAnswer answer = runner_.Run(job, [this](std::int64_t done, std::int64_t total) {
      steps_done_.store(done, std::memory_order_relaxed);
      steps_total_.store(total, std::memory_order_relaxed);
    });
    lock.lock();
    answer_ = std::move(answer);
    lock.unlock();
    on_finished_();
    lock.lock();
  }
}

}  // namespace knap
