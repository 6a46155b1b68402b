// The mesh of a designed body as its cage bends it: read, and refined where the scenario says so.
#pragma once

#include <cstddef>

#include "sim/geometry/triangle_mesh.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Of a refined mesh: every rollout looks at all of them.
inline constexpr std::size_t kMostRefinedTriangles = 20'000;

// `mesh` as on file, in metres, with triangles that are split where an edge is longer than body.refine. Throws
// std::runtime_error with one line that says what is allowed where that would be more than kMostRefinedTriangles.
TriangleMesh RefineDesignedMesh(const DesignedBody& body, TriangleMesh mesh);

}  // namespace knap
