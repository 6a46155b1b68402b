// The engine `bullet`: losses and success of the same scenes in Bullet's dynamics [docs/transfer.md].
#pragma once

#include <memory>

#include "worker/engine.h"

namespace knap {

std::unique_ptr<Engine> MakeBulletEngine();

}  // namespace knap
