#include "coordinator/cli/exit_codes.h"

#include <exception>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatch_types.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

void PrintError(const std::string& what) { WriteComplaint("knap", what); }

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + CleanText(line);
  return text;
}

}  // namespace

UsageError::UsageError(const std::vector<std::string>& lines) : std::runtime_error(JoinLines(lines)) {}

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
