// Where a page of a run that goes on is served.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "coordinator/watch/page_server.h"

namespace knap {

CLI::Option* AddListenFlag(CLI::App* command, std::string* listen);

// Empty: a free port of this machine alone. UsageError for what is no address.
ListenAddress ReadListenFlag(const std::string& listen);

}  // namespace knap
