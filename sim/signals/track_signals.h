// Signals that a state does not tell: what actuators and forces did, the time, and numbers that have none.
#pragma once

#include "sim/signals/signal_function.h"

namespace knap {

std::unique_ptr<SignalFunction> MakeTimeSignal();
std::unique_ptr<SignalFunction> MakeConstantSignal(double value);
std::unique_ptr<SignalFunction> MakeCommandSignal(int row);  // of Track::GetCommand
// The size of the sum of the forces of these of the model's contacts, as Track::GetForce has it.
std::unique_ptr<SignalFunction> MakeForceSignal(int series, std::vector<int> contacts);

}  // namespace knap
