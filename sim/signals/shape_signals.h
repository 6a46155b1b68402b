// What is measured of a design's shape: the same at every moment of a rollout.
#pragma once

#include "sim/signals/signal_function.h"

namespace knap {

// A measure of this value; its cotangent is that of the number-th measure.
std::unique_ptr<SignalFunction> MakeMeasureSignal(double value, int number);

}  // namespace knap
