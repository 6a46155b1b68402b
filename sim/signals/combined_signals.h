// Signals of signals, of at least one part: a − b, √Σ s², the least, the largest. The norm's gradient is zero where it
// is; the least and the largest follow the first part that is it.
#pragma once

#include <vector>

#include "sim/signals/signal_function.h"

namespace knap {

std::unique_ptr<SignalFunction> MakeDifferenceSignal(SignalPointer a, SignalPointer b);
std::unique_ptr<SignalFunction> MakeNormSignal(std::vector<SignalPointer> parts);
std::unique_ptr<SignalFunction> MakeLeastSignal(std::vector<SignalPointer> parts);
std::unique_ptr<SignalFunction> MakeLargestSignal(std::vector<SignalPointer> parts);

}  // namespace knap
