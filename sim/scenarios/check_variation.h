// What a scene's variation must satisfy.
#pragma once

#include "sim/scenarios/field_log.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Reports keys that vary twice, distributions upside down or beyond what their key may be, and draws that the scene
// does not allow. Draws are tried where the scene has no fault so far: each key alone at both ends of its distribution
// and between them, and together with other keys of its body, contact or loss term at the corners of theirs. What a
// draw between those can still do wrong is refused when it is drawn (apply_variation.h).
void CheckVariation(const Scene& scene, FieldLog& log);

}  // namespace knap
