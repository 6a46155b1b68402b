#include "coordinator/run/usage_error.h"

#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    if (!text.empty()) text += '\n';
    text += CleanText(line);
  }
  return text;
}

}  // namespace

UsageError::UsageError(const std::vector<std::string>& lines) : std::runtime_error(JoinLines(lines)) {}

}  // namespace knap
