// The outline of a mesh seen along an axis, for drawings.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

using Outline = std::vector<std::vector<Eigen::Vector2d>>;  // closed loops, the last point joined to the first [m]

// The boundary of those triangles of a closed mesh that turn counter-clockwise in the plane of coordinates `right` and
// `up` (0, 1, 2; different). They cover all that the mesh covers, so the loops, filled by the nonzero rule, are its
// silhouette; where it overlaps itself some loops run inside.
Outline CalcSilhouette(const TriangleMesh& mesh, int right, int up);

}  // namespace knap
