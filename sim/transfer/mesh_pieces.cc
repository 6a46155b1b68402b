#include "sim/transfer/mesh_pieces.h"

#include <fmt/format.h>

#include <stdexcept>
#include <variant>

#include "sim/contact/convex_field.h"
#include "sim/geometry/convex_pieces.h"
#include "sim/geometry/mesh_io.h"
#include "sim/rollout/build_body.h"

namespace knap {
namespace {

// Itself where it is convex.
std::vector<TriangleMesh> MakePieces(const std::string& body, const TriangleMesh& mesh) {
  if (MakeConvexField(mesh)) return {mesh};
  std::vector<TriangleMesh> pieces = MakeConvexPieces(mesh);
  if (pieces.empty()) {
    throw std::runtime_error(fmt::format("mesh of '{}': cannot be taken apart into convex pieces", body));
  }
  return pieces;
}

template <class Kind, class MakeMesh>
MeshPieces MakeAll(const Scene& scene, const MakeMesh& make_mesh) {
  MeshPieces out;
  for (const Body& body : scene.bodies) {
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      const auto* kind = std::get_if<Kind>(&body.shapes[i].kind);
      if (kind != nullptr) out.emplace(std::pair(body.name, i), MakePieces(body.name, make_mesh(body, i, *kind)));
    }
  }
  return out;
}

}  // namespace

MeshPieces MakeFixedPieces(const Scene& scene, const std::map<std::string, std::string>& files) {
  return MakeAll<MeshShape>(scene, [&](const Body& body, std::size_t i, const MeshShape& shape) {
    TriangleMesh mesh = ReadMesh(shape.file, files.at(shape.file), shape.unit);
    const Pose X_BG = MakePose(body.shapes[i]);
    for (Eigen::Vector3d& v : mesh.vertices) v = X_BG * v;
    return mesh;
  });
}

MeshPieces MakeDesignedPieces(const Scene& scene, const DesignedShapes& shapes) {
  return MakeAll<DesignedMeshShape>(
      scene, [&](const Body& body, std::size_t, const DesignedMeshShape&) { return shapes.at(body.name).mesh; });
}

}  // namespace knap
