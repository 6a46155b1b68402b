// The flags by which every command that needs a cluster says which.
#pragma once

#include <CLI/CLI.hpp>

#include "coordinator/run/cluster_session.h"

namespace knap {

// Adds --workers, --external, --engine, --lcm-url, --key and --wait. `options` is written when the command line is
// parsed.
// `own_engines`: whether own workers may have another engine than knap; the command itself refuses names that are none.
void AddClusterFlags(CLI::App* command, ClusterOptions* options, bool own_engines = false);

}  // namespace knap
