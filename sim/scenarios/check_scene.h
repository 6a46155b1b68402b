// What the fields of a scene must satisfy together: everything that no field can tell by itself.
#pragma once

#include "sim/scenarios/field_log.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Reports every contradiction whose fields are right each by itself; see scene.h for the rules. The scene is not
// changed.
void CheckScene(Scene& scene, FieldLog& log);

}  // namespace knap
