#include "coordinator/cli/listen_flag.h"

#include <stdexcept>

#include "coordinator/run/usage_error.h"

namespace knap {

CLI::Option* AddListenFlag(CLI::App* command, std::string* listen) {
  return command->add_option("--listen", *listen,
                             "HOST:PORT to serve the page at (default: 127.0.0.1 and a free port); one that others "
                             "reach gets a token into its address");
}

ListenAddress ReadListenFlag(const std::string& listen) try {
  return listen.empty() ? ListenAddress() : ParseListenAddress(listen);
} catch (const std::invalid_argument& e) {
  throw UsageError(e.what());
}

}  // namespace knap
