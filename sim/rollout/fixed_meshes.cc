#include "sim/rollout/fixed_meshes.h"

#include <fmt/format.h>

#include <stdexcept>
#include <variant>

#include "sim/contact/convex_field.h"
#include "sim/geometry/mesh_io.h"

namespace knap {

FixedMeshes ReadFixedMeshes(const Scene& scene, const std::map<std::string, std::string>& files) {
  FixedMeshes out;
  for (const Body& body : scene.bodies) {
    const auto* shape = body.shape ? std::get_if<MeshShape>(&*body.shape) : nullptr;
    if (shape == nullptr) continue;
    const TriangleMesh mesh = ReadMesh(shape->file, files.at(shape->file), shape->unit);
    const MeshDefects defects = FindDefects(mesh);
    if (!defects.empty()) {
      throw std::runtime_error(
          fmt::format("mesh of '{}': must be closed and face outwards; it has {}", body.name, defects.Describe()));
    }
    out.emplace(body.name, FixedMesh{CalcMassProperties(mesh, 1.0), MakeFixedMesh(mesh)});
  }
  return out;
}

}  // namespace knap
