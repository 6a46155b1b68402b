// What a user asked for that cannot be: every program's exit code 2 [README.md].
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace knap {

// Bad usage or config: one or more lines for the user, complete but for the last one's end. Each stays one line,
// whatever it quotes.
class UsageError : public std::runtime_error {
 public:
  explicit UsageError(const std::string& line) : UsageError(std::vector{line}) {}
  explicit UsageError(const std::vector<std::string>& lines);
};

}  // namespace knap
