// The meshes that no design shapes (MeshShape): read and taken apart once, the same in every rollout.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/contact/contact_shape.h"
#include "sim/geometry/mass_properties.h"
#include "sim/geometry/triangle_mesh.h"
#include "sim/math/pose.h"
#include "sim/scenarios/scene.h"

namespace knap {

// In B, where its shape's pose has it.
struct FixedMesh {
  MassProperties of_unit_density;    // of the mesh, at 1 kg/m³
  std::vector<MeshGeometry> pieces;  // with fields: the mesh itself where it is convex
  std::vector<double> volumes;       // theirs [m³]; they may overlap, and stick out of the mesh
};
using FixedMeshes = std::map<std::pair<std::string, std::size_t>, FixedMesh>;  // by the body's name, the shape's number

// `mesh` in G, closed and facing outwards. Throws std::runtime_error with one line where it cannot be taken apart.
FixedMesh MakeFixedMesh(const TriangleMesh& mesh, const Pose& X_BG);

// `files` as in scenario_files.h. Throws std::runtime_error with one line that names the body where a file holds no
// mesh or one that bounds no body or cannot be taken apart.
FixedMeshes ReadFixedMeshes(const World& world, const std::map<std::string, std::string>& files);

}  // namespace knap
