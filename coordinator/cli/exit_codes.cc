#include "coordinator/cli/exit_codes.h"

#include <exception>
#include <string>

#include "coordinator/dispatch/dispatch_types.h"
#include "coordinator/run/usage_error.h"
#include "lcmtypes/program/standard_streams.h"

namespace knap {
namespace {

void PrintError(const std::string& what) { WriteComplaint("knap", what); }

}  // namespace

int RunCommand(const std::function<int()>& command) {
  try {
    return command();
  } catch (const UsageError& e) {
    WriteMessage(std::string(e.what()) + "\n");
    return kExitUsage;
  } catch (const std::invalid_argument& e) {
    PrintError(e.what());
    return kExitUsage;
  } catch (const NoWorkers& e) {
    PrintError(e.what());
    return kExitNoWorkers;
  } catch (const Interrupted& e) {
    PrintError(e.what());
    return kExitInterrupted;
  } catch (const std::exception& e) {
    PrintError(e.what());
    return kExitFailed;
  }
}

}  // namespace knap
