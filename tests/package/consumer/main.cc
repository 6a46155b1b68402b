// consumer SCENARIO: the loss of one rollout at the initial design and its gradient, to the last bit.
#include <cstdio>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

int main(int, char** argv) {
  const knap::LoadedScenario scenario = knap::LoadScenario(argv[1]);
  if (!scenario.parsed.ok()) {
    std::fputs(scenario.parsed.FormatErrors().c_str(), stderr);
    return 2;
  }
  knap::RolloutModel model(scenario.files);
  knap::RolloutInput input;
  input.theta = model.initial_theta();
  input.variation = {0.0, 0.09};
  const knap::RolloutOutput output = model.Run(input, {});
  std::printf("%.17g\n", output.loss);
  for (const double slope : output.gradient) std::printf("%.17g\n", slope);
}
