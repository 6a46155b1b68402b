// The program's executor: one computing thread, so that heartbeats go on while the engine computes.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "worker/executor.h"
#include "worker/job_runner.h"

namespace knap {

class ThreadedExecutor : public Executor {
 public:
  // `on_finished` is called from the computing thread when an answer waits. The engine must outlive the executor; the
  // destructor waits for the running job.
  ThreadedExecutor(Engine* engine, std::function<void()> on_finished);
  ~ThreadedExecutor() override;

  void Start(ExecutorJob job) override;
  bool busy() const override { return busy_; }
  std::optional<EngineAnswer> TakeAnswer() override;
  StepProgress progress() const override;

 private:
  void RunJobs();

  JobRunner runner_;  // the computing thread's alone
  std::function<void()> on_finished_;
  bool busy_ = false;  // the reactor thread's alone
  std::atomic<std::int64_t> steps_done_{0};
  std::atomic<std::int64_t> steps_total_{0};
  std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  std::optional<ExecutorJob> job_;
  std::optional<EngineAnswer> answer_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace knap
