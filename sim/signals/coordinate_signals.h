// Coordinates q of revolute and prismatic joints, and their rates.
#pragma once

#include "sim/signals/signal_function.h"

namespace knap {

// Of the coordinate with these indices in q and v.
std::unique_ptr<SignalFunction> MakeCoordinateSignal(int q_index, int v_index);
std::unique_ptr<SignalFunction> MakeRateSignal(int v_index);

}  // namespace knap
