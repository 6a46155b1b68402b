// Who the engines of the program knap-worker are: the program itself and how this machine computes.
#pragma once

#include <string>

#include "lcmtypes/wire/engine_identity.h"

namespace knap {

inline constexpr char kKnapEngine[] = "knap";      // the differentiable simulator
inline constexpr char kBulletEngine[] = "bullet";  // the same scenes in Bullet's dynamics, without gradients

bool IsOwnEngine(const std::string& name);

// Of an own engine: its name; build: the first 12 hexadecimal digits of the SHA-256 of the file `program`,
// knap-worker's; fingerprint of CalcKnownNumbers, and of bullet of CalcTransferNumbers besides. Takes some 10 ms.
// Throws std::runtime_error when the file cannot be read.
EngineIdentity MakeOwnIdentity(const std::string& engine, const std::string& program);

}  // namespace knap
