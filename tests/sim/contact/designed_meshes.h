// Meshes that stand for designed ones: with the pieces that other designed ones meet.
#pragma once

#include <memory>
#include <vector>

#include "sim/contact/contact_mesh.h"
#include "sim/contact/moving_pieces.h"

namespace knap::test {

// `pieces` of the mesh before its vertices were moved.
inline MeshGeometry MakeDesigned(const TriangleMesh& mesh, const std::vector<PieceFaces>& pieces) {
  return {std::make_shared<ContactMesh>(mesh), nullptr,
          std::make_shared<MovingPieces>(*MovePieces(pieces, mesh.vertices))};
}
inline MeshGeometry MakeDesigned(const TriangleMesh& mesh) { return MakeDesigned(mesh, FindPieceFaces(mesh)); }

}  // namespace knap::test
