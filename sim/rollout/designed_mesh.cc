#include "sim/rollout/designed_mesh.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/geometry/mesh_refinement.h"

namespace knap {

TriangleMesh RefineDesignedMesh(const DesignedBody& body, TriangleMesh mesh) {
  if (body.refine == 0.0 || CalcLongestEdge(mesh) <= body.refine) return mesh;
  std::optional<TriangleMesh> refined;
  if (mesh.triangles.size() <= kMostRefinedTriangles) refined = RefineMesh(mesh, body.refine, kMostRefinedTriangles);
  if (refined) return std::move(*refined);
  const std::string what = fmt::format("more than {} triangles would come of the {} of {}", kMostRefinedTriangles,
                                       mesh.triangles.size(), body.mesh);
  if (mesh.triangles.size() > kMostRefinedTriangles) {
    throw std::runtime_error(what + "; it is fine enough, 0 is allowed");
  }
  throw std::runtime_error(fmt::format("{}; 0, or {:.6g} mm and more are allowed", what,
                                       1e3 * FindAllowedLength(mesh, body.refine, kMostRefinedTriangles)));
}

}  // namespace knap
