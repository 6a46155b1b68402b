// The engine that the program knap-worker runs.
#pragma once

#include <memory>

#include "worker/engine.h"

namespace knap {

std::unique_ptr<Engine> MakeEngine();

}  // namespace knap
