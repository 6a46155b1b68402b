// The convex pieces of a mesh whose vertices move, as fields that another such mesh is cut up in.
//
// Which vertices make which face is settled once, at the mesh where the pieces were found. Where the vertices are
// elsewhere each face has the plane
//
//   n = a/|a|, a = ½ Σ (p×q + q×r + r×p) over its triangles   d = n·c, c the mean of its triangles' corners
//
// so that a piece is what its planes bound: smooth in the vertices, exactly the piece where its faces are plane, and
// convex always.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "sim/contact/depth_field.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

// A face's triangles, by the vertices of the whole mesh.
using PieceFace = std::vector<Eigen::Vector3i>;
using PieceFaces = std::vector<PieceFace>;

// Of a mesh whose vertices are at one place.
struct MovingPieces {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<PieceFaces> faces;        // of each piece
  std::vector<PolyhedralField> fields;  // likewise, a plane for each of its faces
};

// Of a closed mesh. Throws std::runtime_error with one line where it cannot be taken apart.
std::vector<PieceFaces> FindPieceFaces(const TriangleMesh& mesh);

// Empty where they moved so far that some piece's planes hold nothing, or have no end.
std::optional<MovingPieces> MovePieces(const std::vector<PieceFaces>& pieces,
                                       const std::vector<Eigen::Vector3d>& vertices);

// To the vertices' cotangents, added, from those of the planes of one piece.
void PullBackPlanes(const MovingPieces& pieces, int piece, std::span<const FieldPlane> bar_planes,
                    Eigen::Matrix3Xd* bar_vertices);

}  // namespace knap
