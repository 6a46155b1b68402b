#include "worker/job_runner.h"

#include <exception>
#include <new>
#include <system_error>

#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {

EngineAnswer JobRunner::Run(const ExecutorJob& job, const std::function<void(std::int64_t, std::int64_t)>& progress) {
  EngineAnswer answer;
  try {
    if (loaded_ != job.scenario) {
      loaded_.reset();
      scenario_ = engine_->Load(DecodeBundle(*job.bundle));
      loaded_ = job.scenario;
    }
    if (job.request) answer = scenario_->Run(*job.request, progress);
  } catch (const std::bad_alloc&) {
    answer = EngineAnswer{};
    answer.lack = "out of memory";  // so short that no memory is asked for
  } catch (const std::system_error& e) {
    answer = EngineAnswer{};
    answer.lack = e.what();
  } catch (const std::exception& e) {
    answer = EngineAnswer{};
    answer.error = e.what()[0] == '\0' ? "the engine failed without a reason" : e.what();
  }
  return answer;
}

}  // namespace knap
