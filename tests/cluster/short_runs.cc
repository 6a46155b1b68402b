#include "tests/cluster/short_runs.h"

namespace knap {

std::vector<std::string> MakeShortRun(const std::string& command, const std::string& out,
                                      const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {command,
                                        KNAP_SOURCE_DIR "/configs/pushing.yaml",
                                        "rollout.horizon=2 s",
                                        "rollout.step=4 ms",
                                        "learning.variations=4",
                                        "learning.batch=2",
                                        "learning.max_evaluations=3",
                                        "evaluation.variations=6",
                                        "--out",
                                        out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> MakeSlowLearning(const std::string& out, std::vector<std::string> more) {
  more.insert(more.begin(), {"rollout.step=2 ms", "learning.variations=12"});
  return MakeShortRun("learn", out, more);
}

}  // namespace knap
