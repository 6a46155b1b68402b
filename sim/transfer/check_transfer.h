// What Bullet's engine cannot represent of a scene.
#pragma once

#include <string>
#include <vector>

#include "sim/scenarios/scene.h"

namespace knap {

// One line each, which names the field; empty where the scene can be simulated:
// - joints other than fixed, prescribed and free, and so their actuators, controls, policies and signals;
// - bodies that hang on a free one, half-spaces of free bodies;
// - grips that a free body holds;
// - signals of a contact's force or of an actuator's command.
std::vector<std::string> FindTransferFaults(const Scene& scene);

}  // namespace knap
