// KNAP_CHECK(condition, "format", values…) aborts in every build when knap itself is wrong, and prints the values.
// It is never for bad input (throw at the edge) nor for numerical outcomes (a status in the result).
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#define KNAP_CHECK(condition, ...)                                                                                   \
  do {                                                                                                               \
    if (!(condition)) {                                                                                              \
      fmt::print(stderr, "{}:{}: check failed: {}: {}\n", __FILE__, __LINE__, #condition, fmt::format(__VA_ARGS__)); \
      std::abort();                                                                                                  \
    }                                                                                                                \
  } while (false)
