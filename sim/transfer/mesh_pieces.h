// The convex pieces with which meshes touch in Bullet. A mesh that is not convex is taken apart as theta has deformed
// it (convex_pieces.h): the pieces stick out of it by up to about 1% of its size.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/geometry/triangle_mesh.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"

namespace knap {

// In B: by the body's name and the shape's number.
using MeshPieces = std::map<std::pair<std::string, std::size_t>, std::vector<TriangleMesh>>;

// Of the meshes that no design shapes. `files` as in scenario_files.h. Throws std::runtime_error with one line that
// names the body where a mesh cannot be taken apart.
MeshPieces MakeFixedPieces(const Scene& scene, const std::map<std::string, std::string>& files);

// Of the designed ones, which have no faults; likewise.
MeshPieces MakeDesignedPieces(const Scene& scene, const DesignedShapes& shapes);

}  // namespace knap
