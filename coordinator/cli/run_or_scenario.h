// Where a command finds its scenario and its designs.
#pragma once

#include <cstddef>
#include <filesystem>

#include "coordinator/cli/theta_choice.h"

namespace knap {

// What commands on designs get by name: a run, whose design is the learned one, or a scenario file.
class RunOrScenario {
 public:
  explicit RunOrScenario(const std::filesystem::path& path);
  const std::filesystem::path& config() const { return config_; }
  // The learned design is what ReadLearnedTheta returns, and a run's default; UsageError for a scenario. This must
  // outlive what is returned.
  NamedDesigns NameDesigns(std::size_t size) const;

 private:
  std::filesystem::path path_;
  bool is_run_;
  std::filesystem::path config_;
};

}  // namespace knap
