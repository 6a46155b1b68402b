#include "sim/transfer/transfer_numbers.h"

#include <LinearMath/btScalar.h>

#include "sim/rollout/known_numbers.h"
#include "sim/transfer/transfer_model.h"

namespace knap {

std::vector<double> CalcTransferNumbers() {
  TransferModel model(MakeKnownScenario());
  const TransferOutput out = model.Run(model.design()->initial_theta(), {0.002}, {});
  std::vector<double> numbers = {static_cast<double>(btGetVersion()), out.loss, out.largest_force};
  for (const BodyHistory::State& state : model.history().states) {
    numbers.insert(numbers.end(), state.X_WB.back().p.begin(), state.X_WB.back().p.end());
    numbers.insert(numbers.end(), state.V.back().begin(), state.V.back().end());
  }
  return numbers;
}

}  // namespace knap
