// The engine `knap`: the differentiable simulator.
#pragma once

#include <memory>

#include "worker/engine.h"

namespace knap {

std::unique_ptr<Engine> MakeKnapEngine();

}  // namespace knap
