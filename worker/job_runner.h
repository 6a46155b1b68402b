// Runs one job on an engine in the calling thread, whatever the executor around it.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "worker/executor.h"

namespace knap {

class JobRunner {
 public:
  // The engine must outlive the runner.
  explicit JobRunner(Engine* engine) : engine_(engine) {}

  // Loads the scenario when it is not the one loaded, then runs the request, if any. An exception of the engine becomes
  // the answer's error; std::bad_alloc and std::system_error become its lack, for they say nothing about the request.
  EngineAnswer Run(const ExecutorJob& job, const std::function<void(std::int64_t, std::int64_t)>& progress);

 private:
  Engine* engine_;
  std::optional<ContentId> loaded_;
  std::unique_ptr<EngineScenario> scenario_;
};

}  // namespace knap
