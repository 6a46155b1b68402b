// Splitting the polygons of a mesh into triangles.
//
// A polygon of n corners becomes n − 2 triangles of its own corners, by cutting off ears [Meisters 1975]: a corner is
// an ear when it is convex and the triangle of it and its neighbours holds no other corner, neither inside nor on its
// edges. A simple polygon of more than three corners has at least two ears, also when some of its corners lie on a
// straight line with their neighbours, so that no rule about the first corner is needed.
//
// Corners come from files and are rounded: whatever lies within 1e-10 of the polygon's size from an edge counts as
// lying on it. Only when no ear is left under this rule it is dropped, for outlines with real features of that size.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace knap {

struct PolygonSplit {
  std::vector<Eigen::Vector3i> triangles;  // indices into the polygon's corners, in the polygon's sense of rotation
  std::string fault;                       // why the polygon cannot be split, then there are no triangles; else empty
};

// `corners` in the order of the outline, at least three, finite; they need not lie exactly in one plane and are looked
// at along the axis to which the polygon's area is most nearly perpendicular. A convex quadrangle 0 1 2 3 becomes 0 1 2
// and 0 2 3. A hole may be reached over a bridge, an edge that the outline takes there and back.
// Faults: no area, an outline that crosses itself. O(n²) time for n corners with concave ones among them.
PolygonSplit SplitPolygon(const std::vector<Eigen::Vector3d>& corners);

}  // namespace knap
