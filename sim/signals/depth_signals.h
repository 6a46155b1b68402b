// How deep bodies press into one another.
#pragma once

#include <vector>

#include "sim/contact/contact_side.h"
#include "sim/signals/signal_function.h"

namespace knap {

// The largest depth of those of the model's contacts whose numbers are given; 0 where none touches [m]. Its gradient
// reaches the vertices of a designed mesh too.
std::unique_ptr<SignalFunction> MakeDepthSignal(const std::vector<ContactPair>& contacts, std::vector<int> numbers);

}  // namespace knap
