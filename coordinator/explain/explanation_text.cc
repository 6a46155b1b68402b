#include "coordinator/explain/explanation_text.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace knap {
namespace {

struct Words {
  const char* why;     // as events.jsonl has it
  const char* gone;    // what the worker did
  const char* reason;  // of the request
};

constexpr std::array<Words, 10> kWords = {{
    {"died", "died", "its worker died"},
    {"faulted", "crashed", "its worker crashed (a fault signal)"},
    {"silent", "was not heard any more", "its worker was not heard any more"},
    {"stopping", "left", "its worker left"},
    {"lacking", "left for want of something", "its worker left for want of something"},
    {"stuck", "made no progress", "its worker made no progress"},
    {"elsewhere", "turned to another run", "its worker turned to another run"},
    {"straggler", "straggled", "it took long, and an idle worker got a second copy"},
    {"message_lost", "had not got it", "a message was lost, and it was sent again"},
    {"dropped", "was told to drop it", "the run was broken off while it was open"},
}};

}  // namespace

void Explanation::Add(const std::string& about, const std::string& line) {
  const bool is_new = !about.empty() && about != about_;
  if (is_new) about_ = about;
  text_ += fmt::format("{:<10} {}\n", is_new ? about : "", line);
}

std::string FormatInstant(double time_s) { return fmt::format("{:.3f} s", time_s); }

std::string FormatSpan(double seconds) {
  return seconds < 1.0 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3f} s", seconds);
}

double CalcComputing(const RolloutRow& answer) { return answer.forward_s + answer.gradient_s; }

std::string DescribeComputing(const RolloutRow& answer) {
  constexpr double kNothing_s = 1e-5;  // it takes a while to find that there is nothing to do
  return FormatSpan(answer.forward_s) + " forward" +
         (answer.gradient_s > kNothing_s ? " and " + FormatSpan(answer.gradient_s) + " gradient" : "");
}

std::string DescribeGone(const std::string& why) {
  for (const Words& words : kWords) {
    if (why == words.why) return words.gone;
  }
  return why;
}

std::string DescribeWhy(const std::string& why) {
  for (const Words& words : kWords) {
    if (why == words.why) return words.reason;
  }
  return why;
}

}  // namespace knap
