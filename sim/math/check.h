// KNAP_CHECK(condition, "format", values…) aborts in every build when knap itself is wrong, and prints the values.
// It is never for bad input (throw at the edge) nor for numerical outcomes (a status in the result).
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#define KNAP_CHECK(condition, ...)                                                                         \
  do {                                                                                                     \
    if (!(condition)) {                                                                                    \
      /* Not fmt::print, which throws when stderr takes nothing: that would be an error where we abort. */ \
      const std::string said = fmt::format(__VA_ARGS__);                                                   \
      std::fprintf(stderr, "%s:%d: check failed: %s: %s\n", __FILE__, __LINE__, #condition, said.c_str()); \
      std::abort();                                                                                        \
    }                                                                                                      \
  } while (false)
