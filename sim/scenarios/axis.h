// An axis of a frame, as a scenario names it.
#pragma once

namespace knap {

enum class Axis { kX, kY, kZ };

}  // namespace knap
