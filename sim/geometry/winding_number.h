// How often a surface goes round a point: 1 inside a closed, outward oriented one, 0 outside, −1 inside one that faces
// inwards. It is the sum of the solid angles of the triangles seen from the point, over 4π [Van Oosterom
// 1983].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Of the triangles with these indices, which are in range; the point does not lie on them. Within rounding an integer
// when they are closed. O(number of triangles).
double CalcWindingNumber(const TriangleMesh& mesh, const std::vector<int>& triangles, const Eigen::Vector3d& p);

}  // namespace knap
