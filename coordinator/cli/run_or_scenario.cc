#include "coordinator/cli/run_or_scenario.h"

#include <fmt/format.h>

#include <vector>

#include "coordinator/run/loaded_run.h"
#include "coordinator/run/usage_error.h"

namespace knap {

RunOrScenario::RunOrScenario(const std::filesystem::path& path)
    : path_(path),
      is_run_(std::filesystem::is_directory(path)),
      config_(is_run_ ? OpenRun(path).config_path() : path) {}

NamedDesigns RunOrScenario::NameDesigns(std::size_t size) const {
  return {is_run_ ? "learned" : "initial", [this, size] {
            if (!is_run_) throw UsageError(fmt::format("--theta learned: {} is a scenario, not a run", path_.string()));
            return ReadLearnedTheta(OpenRun(path_), size);
          }};
}

}  // namespace knap
