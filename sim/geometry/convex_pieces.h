// Convex pieces that together fill a mesh, more or less. The library HACD merges neighbouring triangles as long as
// their hull follows them [Mamou & Ghorbel 2009]; the pieces are the hulls of its clusters (convex_hull.h).
#pragma once

#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// `mesh` bounds one or several bodies (FindDefects is empty). Vertices are some of the mesh's; pieces may overlap, and
// stick out of the mesh by about 1% of its size. The same for the same mesh, always. Takes a second for a thousand
// triangles.
std::vector<TriangleMesh> MakeConvexPieces(const TriangleMesh& mesh);

}  // namespace knap
