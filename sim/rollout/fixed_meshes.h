// The meshes of bodies that no design shapes (MeshShape): read once, the same in every rollout.
#pragma once

#include <map>
#include <string>

#include "sim/contact/contact_shape.h"
#include "sim/geometry/mass_properties.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct FixedMesh {
  MassProperties of_unit_density;  // at 1 kg/m³
  MeshGeometry contact;            // with a field where it is convex
};
using FixedMeshes = std::map<std::string, FixedMesh>;  // by the body's name

// `files` as in scenario_files.h. Throws std::runtime_error with one line that names the body where a file holds no
// mesh or one that bounds no body.
FixedMeshes ReadFixedMeshes(const Scene& scene, const std::map<std::string, std::string>& files);
}  // namespace knap
