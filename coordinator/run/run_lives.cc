#include "coordinator/run/run_lives.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/run_logs.h"

namespace knap {

std::vector<RunLife> ReadLives(const RunDirectory& run) {
  std::vector<RunLife> lives;
  if (std::filesystem::exists(run.events_path())) {
    for (const nlohmann::ordered_json& event : ParseEvents(ReadFile(run.events_path()))) {
      if (event.value("event", "") != "begin" || !event.contains("run_id")) continue;
      lives.push_back({static_cast<std::int64_t>(std::stoull(event.at("run_id").get<std::string>(), nullptr, 16)),
                       event.at("lcm_url").get<std::string>(), event.at("key_file").get<std::string>()});
    }
  }
  if (lives.empty()) {
    throw UsageError(fmt::format("{}: no beginning of a run with its number and address", run.events_path().string()));
  }
  return lives;
}

}  // namespace knap
