// Bodies and frames at a moment.
#pragma once

#include <cstddef>

#include "sim/signals/signal_function.h"

namespace knap {

inline const BodyKinematics& GetKinematics(const Moment& at, int body) {
  return at.kinematics[static_cast<std::size_t>(body)];
}

// Of a body, or of the world where it is negative.
inline Pose GetFrame(const Moment& at, int body) { return body < 0 ? Pose{} : GetKinematics(at, body).X_WB; }

}  // namespace knap
