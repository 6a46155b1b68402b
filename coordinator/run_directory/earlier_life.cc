#include "coordinator/run_directory/earlier_life.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/run_logs.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
EarlierLife ReadEarlierLife(const RunDirectory& run) {
  EarlierLife life;
  // A line without its end is the trace of a crash, even where it happens to be whole.
  std::string events = std::filesystem::exists(run.events_path()) ? ReadFile(run.events_path()) : "";
  events.resize(events.rfind('\n') + 1);  // npos + 1 = 0: no whole line
  for (const nlohmann::ordered_json& event : ParseEvents(events)) {
    life.worked_s = std::max(life.worked_s, event.value("time_s", 0.0));
    if (event.value("event", "") == "requests_reissued") life.reissued = event.value("total", life.reissued);
  }
  if (!std::filesystem::exists(run.rollouts_path())) return life;
  const CsvTable rollouts(ReadFile(run.rollouts_path()));
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    const double time_s = rollouts.GetNumber(i, "time_s");
    if (time_s > life.worked_s) life.worked_s = time_s;
  }
  return life;
}

}  // namespace knap
