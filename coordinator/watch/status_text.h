// A cluster view for people, as a table, and for programs, as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "coordinator/watch/cluster_view.h"

namespace knap {

// Lines of at most `width` columns, each with a line end; yellow for what deserves attention when `colour`.
std::string FormatStatus(const ClusterView& view, std::int64_t now_us, int width, bool colour);

// {"schema": 1, "url": …, "runs": […], "workers": […], "messages_refused": …}; an unknown time left is null.
nlohmann::ordered_json MakeStatusJson(const ClusterView& view, std::int64_t now_us, const std::string& url);

}  // namespace knap
