// The line that an action throws, for tests that compare it with what a user should read.
#pragma once

#include <exception>
#include <functional>
#include <string>

namespace knap {

inline std::string CatchLine(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "nothing was thrown";
}

}  // namespace knap
