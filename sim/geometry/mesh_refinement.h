// Meshes made finer without a change of their shape: for what bends with a cage, which moves vertices alone.
#pragma once

#include <cstddef>
#include <optional>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// The length of the longest edge [m]; 0 without triangles. Indices are in range.
double CalcLongestEdge(const TriangleMesh& mesh);

// Splits triangles at the midpoints of their edges until no edge is longer than `longest` [m], more than 0. An edge is
// split, or not, for both of its triangles: a closed mesh stays closed and manifold, every vertex stays where and what
// it was (new ones follow), and new triangles lie in the old ones and face as they do, but for rounding. Of a triangle
// with all edges split four arise, with two three (across the shorter diagonal), with one two.
//
// Empty where more than `most_triangles` would be needed. Deterministic; indices are in range, and vertices finite.
// O(n log n) of what comes out.
std::optional<TriangleMesh> RefineMesh(const TriangleMesh& mesh, double longest, std::size_t most_triangles);

// A length above `longest` with which RefineMesh keeps to that number: rounded up to two digits, at most a quarter more
// than needed. `mesh` itself has no more.
double FindAllowedLength(const TriangleMesh& mesh, double longest, std::size_t most_triangles);

}  // namespace knap
