#include "sim/policy/weights_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace knap {

Eigen::VectorXd ParseWeights(const std::string& text, const std::string& name, Eigen::Index count, double lower,
                             double upper) {
  std::vector<double> weights;
  std::size_t line = 1;
  std::size_t line_begin = 0;
  const auto fail = [&](std::size_t at, const std::string& message) {
    throw std::runtime_error(fmt::format("{}:{}:{}: {}", name, line, at - line_begin + 1, message));
  };
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == '\n') {
      ++line;
      line_begin = ++at;
    } else if (c == ' ' || c == '\t' || c == '\r') {
      ++at;
    } else if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      const std::size_t end = std::min(text.find_first_of(" \t\r\n#", at), text.size());
      double value = 0.0;
      const auto [stop, error] = std::from_chars(text.data() + at, text.data() + end, value);
      const std::string shown = text.substr(at, std::min<std::size_t>(end - at, 40));
      if (error != std::errc() || stop != text.data() + end || !std::isfinite(value)) {
        fail(at, fmt::format("value '{}': expected a weight, a decimal number", shown));
      }
      if (value < lower || value > upper) {
        fail(at, fmt::format("value '{}': must lie from lower, {}, to upper, {}", shown, lower, upper));
      }
      if (static_cast<Eigen::Index>(weights.size()) == count) {
        fail(at, fmt::format("value '{}': one weight too many; the policy's network has {}", shown, count));
      }
      weights.push_back(value);
      at = end;
    }
  }
  if (static_cast<Eigen::Index>(weights.size()) != count) {
    fail(at, fmt::format("has {} weights; the policy's network has {}", weights.size(), count));
  }
  return Eigen::Map<const Eigen::VectorXd>(weights.data(), count);
}

std::string FormatWeights(const Eigen::VectorXd& weights, const std::string& remark) {
  std::string text = "# ";
  for (const char c : remark) text += c == '\n' ? "\n# " : std::string(1, c);
  text += '\n';
  for (const double weight : weights) text += fmt::format("{}\n", weight);
  return text;
}

}  // namespace knap
