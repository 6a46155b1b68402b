// How explanations are laid out and worded.
#pragma once

#include <string>

#include "coordinator/run_directory/run_logs.h"

namespace knap {

// Lines with what they are about in front of the first of those that are about the same.
class Explanation {
 public:
  void Add(const std::string& about, const std::string& line);
  std::string Take() const { return text_; }

 private:
  std::string text_, about_;
};

// "12.345 s", after the run's beginning.
std::string FormatInstant(double time_s);
// "12.3 ms", "4.5 s".
std::string FormatSpan(double seconds);

// What the worker measured itself; NaN where it is not recorded.
double CalcComputing(const RolloutRow& answer);
// "30 ms forward and 6 ms gradient"; nothing of a gradient that was not asked for.
std::string DescribeComputing(const RolloutRow& answer);

// What a TroubleKind's name in events.jsonl means: what the worker did, as "was not heard any more", and what it was
// for a request, as "its worker was not heard any more". An unknown one as it is.
std::string DescribeGone(const std::string& why);
std::string DescribeWhy(const std::string& why);

}  // namespace knap
