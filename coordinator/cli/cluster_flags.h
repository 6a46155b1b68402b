// The flags by which every command that needs a cluster says which.
#pragma once

#include <CLI/CLI.hpp>

#include "coordinator/run/cluster_session.h"

namespace knap {

// Adds --workers, --external, --engine, --lcm-url, --key and --wait. `options` is written when the command line is
// parsed.
void AddClusterFlags(CLI::App* command, ClusterOptions* options);

}  // namespace knap
