// The convex hull of points, by the library Qhull [Barber, Dobkin & Huhdanpaa 1996].
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Closed and facing outwards but for slivers, triangles without an area, which are left out. Its vertices are some of
// the points, in their order. Empty where all points lie in a plane, up to rounding.
std::optional<TriangleMesh> MakeConvexHull(const std::vector<Eigen::Vector3d>& points);

}  // namespace knap
