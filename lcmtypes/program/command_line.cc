#include "lcmtypes/program/command_line.h"

#include <sstream>
#include <system_error>

#include "lcmtypes/program/standard_streams.h"

namespace knap {

int EndParsing(const CLI::App& app, const CLI::ParseError& end) {
  std::ostringstream asked_for, wrong;
  const int code = app.exit(end, asked_for, wrong);
  WriteMessage(wrong.str());
  if (code != 0) return 2;
  try {
    WriteOutput(asked_for.str());
    return 0;
  } catch (const std::system_error& e) {
    WriteMessage(app.get_name() + ": " + e.what() + "\n");
    return 1;
  }
}

}  // namespace knap
