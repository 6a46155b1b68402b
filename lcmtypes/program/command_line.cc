#include "lcmtypes/program/command_line.h"

#include <sstream>
#include <system_error>

#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {

int EndParsing(const CLI::App& app, const CLI::ParseError& end) {
  std::ostringstream asked_for, wrong;
  if (end.get_exit_code() != 0) {
    // One line, whatever the command line holds, and the hint to --help below it.
    app.exit(CLI::ParseError(CleanText(end.what()), end.get_exit_code()), asked_for, wrong);
    WriteMessage(wrong.str());
    return 2;
  }
  app.exit(end, asked_for, wrong);
  try {
    WriteOutput(asked_for.str());
    return 0;
  } catch (const std::system_error& e) {
    WriteComplaint(app.get_name(), e.what());
    return 1;
  }
}

}  // namespace knap
