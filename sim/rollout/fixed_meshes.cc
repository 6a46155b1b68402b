#include "sim/rollout/fixed_meshes.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <variant>

#include "sim/contact/convex_field.h"
#include "sim/geometry/convex_pieces.h"
#include "sim/geometry/mesh_io.h"
#include "sim/rollout/build_body.h"

namespace knap {

namespace {

TriangleMesh Move(const Pose& X, TriangleMesh mesh) {
  for (Eigen::Vector3d& v : mesh.vertices) v = X * v;
  return mesh;
}

}  // namespace

FixedMesh MakeFixedMesh(const TriangleMesh& mesh, const Pose& X_BG) {
  FixedMesh out;
  const TriangleMesh placed = Move(X_BG, mesh);
  out.of_unit_density = CalcMassProperties(placed, 1.0);
  if (std::optional<MeshGeometry> whole = MakeConvexMesh(placed)) {
    out.pieces.push_back(*std::move(whole));
    out.volumes.push_back(out.of_unit_density.mass);
    return out;
  }
  for (const TriangleMesh& piece : MakeConvexPieces(mesh)) {
    std::optional<MeshGeometry> convex = MakeConvexMesh(Move(X_BG, piece));
    if (!convex) throw std::runtime_error(fmt::format("a piece of it is not convex, or has over {} faces", kMostFaces));
    out.pieces.push_back(*std::move(convex));
    out.volumes.push_back(CalcMassProperties(piece, 1.0).mass);
  }
  if (out.pieces.empty()) throw std::runtime_error("cannot be taken apart into convex pieces");
  return out;
}

FixedMeshes ReadFixedMeshes(const World& world, const std::map<std::string, std::string>& files) {
  FixedMeshes out;
  for (const Body& body : world.bodies) {
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      const auto* shape = std::get_if<MeshShape>(&body.shapes[i].kind);
      if (shape == nullptr) continue;
      const TriangleMesh mesh = ReadMesh(shape->file, files.at(shape->file), shape->unit);
      const MeshDefects defects = FindDefects(mesh);
      if (!defects.empty()) {
        throw std::runtime_error(
            fmt::format("mesh of '{}': must be closed and face outwards; it has {}", body.name, defects.Describe()));
      }
      try {
        out.emplace(std::pair(body.name, i), MakeFixedMesh(mesh, MakePose(body.shapes[i])));
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(fmt::format("mesh of '{}': {}", body.name, error.what()));
      }
    }
  }
  return out;
}

}  // namespace knap
