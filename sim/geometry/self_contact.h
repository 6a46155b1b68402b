// Whether a mesh meets itself: two triangles that have a point in common beyond the corners and edges they share.
//
// Triangles are convex, so two of them are apart exactly when some axis separates their shadows on it: the normal of
// one, a normal of two of their edges, or in their common plane a normal of an edge [Gottschalk 1996].
// With one common corner they meet elsewhere exactly when the edge opposite to it in one of them meets the other; with
// a common edge, when one is folded back upon the other.
#pragma once

#include <array>
#include <optional>

#include "sim/geometry/triangle_bvh.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

// The first such pair, by the index of its first triangle and then of its second. Touching counts: what is not apart by
// more than rounding, 1e-12 of the mesh's size, meets. Indices are in range, coordinates finite, corners of a triangle
// distinct, and bvh is that of this mesh.
std::optional<std::array<int, 2>> FindSelfContact(const TriangleMesh& mesh, const TriangleBvh& bvh);

}  // namespace knap
