// Convex pieces that together fill a mesh, more or less, by the library HACD: it merges neighbouring triangles as long
// as their hull follows them [Mamou & Ghorbel 2009].
#pragma once

#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// `mesh` bounds one or several bodies (FindDefects is empty). Each piece is the hull of some of its vertices, closed
// and outward; pieces may overlap and stick out of the mesh by about 1% of its size. The same for the same mesh,
// always. Takes a second for a thousand triangles.
std::vector<TriangleMesh> MakeConvexPieces(const TriangleMesh& mesh);

}  // namespace knap
