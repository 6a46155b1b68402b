// A cluster view for people, as a table, and for programs, as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "coordinator/watch/cluster_view.h"

namespace knap {

// What the folder of a run adds to what the bus tells of it.
struct RunTraits {
  std::string loss_unit;    // what follows a loss, such as " mm²"; empty: it has none
  bool has_success = true;  // the scenario has a success test
};
using KnownRuns = std::map<std::int64_t, RunTraits>;  // by run id; of those whose folder is not known there is nothing

// Lines of at most `width` columns, each with a line end; yellow for what deserves attention when `colour`.
std::string FormatStatus(const ClusterView& view, const KnownRuns& known, std::int64_t now_us, int width, bool colour);

// {"schema": 1, "url": …, "runs": […], "workers": […], "messages_refused": …}; what is not known is null: the time
// left, a loss before the first evaluation, unit and success test of a run that is not in `known`.
nlohmann::ordered_json MakeStatusJson(const ClusterView& view, const KnownRuns& known, std::int64_t now_us,
                                      const std::string& url);

}  // namespace knap
