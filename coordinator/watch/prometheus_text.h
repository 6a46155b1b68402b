// A cluster view in the text format of Prometheus, as node_exporter's collector of text files takes it.
#pragma once

#include <cstdint>
#include <string>

#include "coordinator/watch/cluster_view.h"

namespace knap {

// Metrics knap_run_… with the labels scenario, method, run and knap_worker_… with worker, host, engine, instance, each
// with its HELP and TYPE; what is not known is left out.
std::string FormatPrometheus(const ClusterView& view, std::int64_t now_us);

}  // namespace knap
