// Which vertices of a cage a group has.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/geometry/triangle_mesh.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Those that the group names; those in its box; or those on the side of its plane to which the normal points. What lies
// on the boundary, within 1e-9 of the cage's size, counts. Ascending where the group does not name them itself.
std::vector<std::int64_t> ListVertices(const VertexGroup& group, const TriangleMesh& cage);

}  // namespace knap
