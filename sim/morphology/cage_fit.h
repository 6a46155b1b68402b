// Whether a mesh lies inside its cage. Outside of it mean value coordinates are defined but grow and change sign, so
// that a small move of the cage becomes a large and strange one of the mesh; the usual reason is two files in unlike
// units.
#pragma once

#include <string>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Empty when every vertex of the mesh lies in the cage, or on it within 1e-9 of the cage's size; else one line with
// both sizes. The cage has no defects.
std::string DescribeMisfit(const TriangleMesh& mesh, const TriangleMesh& cage);

}  // namespace knap
