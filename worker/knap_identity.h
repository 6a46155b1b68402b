// Who the engine `knap` is: the program knap-worker and how this machine computes.
#pragma once

#include <string>

#include "lcmtypes/wire/engine_identity.h"

namespace knap {

// Name `knap`; build: the first 12 hexadecimal digits of the SHA-256 of the file `program`, knap-worker's; fingerprint
// of CalcKnownNumbers. Takes some 10 ms. Throws std::runtime_error when the file cannot be read.
EngineIdentity MakeKnapIdentity(const std::string& program);

}  // namespace knap
