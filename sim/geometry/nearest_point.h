// The point of a triangle that is nearest to the origin.
#pragma once

#include <Eigen/Core>

namespace knap {

// Its barycentric coordinates in the triangle (a, b, c), none of them negative, by the Voronoi region it lies in: a
// corner, an edge or the inside [Ericson, Real-Time Collision Detection, 5.1.5]. The triangle has an area.
Eigen::Vector3d CalcNearestToOrigin(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace knap
