// What the fields of a scene must satisfy together: everything that no field can tell by itself.
#pragma once

#include "sim/scenarios/field_log.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Reports every contradiction whose fields are right each by itself; see scene.h for the rules. Changes what
// the file leaves open and the rest of it settles: counts of a scene where nothing varies, or with few parameters.
void CheckScene(Scene& scene, FieldLog& log);

}  // namespace knap
