// Where a worker's computations run: in a thread of their own in the program, in simulated time in tests.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "lcmtypes/wire/content_id.h"
#include "worker/engine.h"

namespace knap {

struct StepProgress {
  std::int64_t done = 0;   // steps finished in the running request
  std::int64_t total = 0;  // steps that it has; 0 when unknown or nothing runs
};

struct ExecutorJob {
  ContentId scenario{};
  std::shared_ptr<const std::string> bundle;  // the scenario's bytes, loaded first unless it was the last one used
  std::optional<EngineRequest> request;       // empty: only load the scenario
};

// Runs one job at a time. All functions are called by one thread, the reactor's.
class Executor {
 public:
  virtual ~Executor() = default;

  // Precondition: !busy(). Never throws for what the engine does: a throwing engine gives an answer with its error.
  virtual void Start(ExecutorJob job) = 0;

  // True from Start until TakeAnswer returned the answer.
  virtual bool busy() const = 0;

  // The finished job's answer, once; empty while it runs. Of a job that only loads, `error` alone means something.
  virtual std::optional<EngineAnswer> TakeAnswer() = 0;

  virtual StepProgress progress() const = 0;
};

}  // namespace knap
