// Numbers by which two machines find out whether they compute alike, before they share a run.
//
// One program gives other bits on another processor when the mathematical library picks another variant of a function
// (with or without fused multiply-add, say), and with another library. So the numbers are
//  - a sweep over the elementary functions: each at 200 points spread over its useful range, and
//  - a known rollout: a sphere that rolls on a plane and is swept by a designed box, loss and gradient of a task and of
//    a distillation term (the scene is in known_numbers.cc; it takes a few milliseconds).
// Equal numbers do not prove equal programs: the build is compared beside them [lcmtypes/wire/engine_identity.h].
#pragma once

#include <map>
#include <string>
#include <vector>

namespace knap {

// The scenario of the known rollout: two parameters, one varied number.
std::map<std::string, std::string> MakeKnownScenario();

// Pure; the same bits in every call of one process.
std::vector<double> CalcKnownNumbers();

}  // namespace knap
