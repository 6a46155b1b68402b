// Commands on Pushing that are coarse and short: the pea is met and swept aside, a run takes a second.
#pragma once

#include <string>
#include <vector>

namespace knap {

// `command` (learn, study) into the folder `out`; what is in `more`, which may be scenario keys again, counts.
std::vector<std::string> MakeShortRun(const std::string& command, const std::string& out,
                                      const std::vector<std::string>& more);

// `knap learn`, slow enough for something to happen meanwhile.
std::vector<std::string> MakeSlowLearning(const std::string& out, std::vector<std::string> more);

}  // namespace knap
