#include "sim/contact/moving_pieces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <stdexcept>

#include "sim/contact/convex_field.h"
#include "sim/geometry/convex_pieces.h"

namespace knap {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

std::array<Vector3d, 3> GetCorners(const Vector3i& triangle, const std::vector<Vector3d>& vertices) {
  std::array<Vector3d, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    out[k] = vertices[static_cast<std::size_t>(triangle[static_cast<Eigen::Index>(k)])];
  }
  return out;
}

// a and c of a face.
struct FaceShape {
  Vector3d area = Vector3d::Zero();
  Vector3d middle = Vector3d::Zero();

  FaceShape(const PieceFace& face, const std::vector<Vector3d>& vertices) {
    for (const Vector3i& t : face) {
      const auto [p, q, r] = GetCorners(t, vertices);
      area += 0.5 * (q - p).cross(r - p);
      middle += (p + q + r) / (3.0 * static_cast<double>(face.size()));
    }
  }
};

}  // namespace

std::vector<PieceFaces> FindPieceFaces(const TriangleMesh& mesh) {
  std::map<std::array<double, 3>, int> vertex_at;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d& v = mesh.vertices[i];
    vertex_at.emplace(std::array{v.x(), v.y(), v.z()}, static_cast<int>(i));
  }
  std::vector<TriangleMesh> pieces;
  if (FindConvexFaces(mesh)) {
    pieces = {mesh};
  } else {
    pieces = MakeConvexPieces(mesh);
  }
  std::vector<PieceFaces> out;
  for (const TriangleMesh& piece : pieces) {
    const std::optional<std::vector<ConvexFace>> faces = FindConvexFaces(piece);
    if (!faces) throw std::runtime_error(fmt::format("a piece of it is not convex, or has over {} faces", kMostFaces));
    PieceFaces& of_piece = out.emplace_back();
    for (const ConvexFace& face : *faces) {
      PieceFace& triangles = of_piece.emplace_back();
      for (const int number : face.triangles) {
        Vector3i triangle;
        for (int k = 0; k < 3; ++k) {
          const Vector3d& v = piece.vertices[piece.triangles[number][k]];
          triangle[k] = vertex_at.at({v.x(), v.y(), v.z()});
        }
        triangles.push_back(triangle);
      }
    }
  }
  if (out.empty()) throw std::runtime_error("cannot be taken apart into convex pieces");
  return out;
}

std::optional<MovingPieces> MovePieces(const std::vector<PieceFaces>& pieces, const std::vector<Vector3d>& vertices) {
  MovingPieces out{vertices, pieces, {}};
  for (const PieceFaces& faces : pieces) {
    PolyhedralField& field = out.fields.emplace_back();
    for (const PieceFace& face : faces) {
      const FaceShape shape(face, vertices);
      const Vector3d n = shape.area.normalized();
      field.planes.push_back({n, n.dot(shape.middle)});
      for (const Vector3i& t : face) {
        for (const Vector3d& x : GetCorners(t, vertices)) field.bounds.extend(x);
      }
    }
    if (!FitBounds(&field)) return std::nullopt;
  }
  return out;
}

void PullBackPlanes(const MovingPieces& pieces, int piece, std::span<const FieldPlane> bar_planes,
                    Eigen::Matrix3Xd* bar_vertices) {
  const PieceFaces& faces = pieces.faces[static_cast<std::size_t>(piece)];
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const FieldPlane& bar = bar_planes[i];
    const FaceShape shape(faces[i], pieces.vertices);
    const double size = shape.area.norm();
    const Vector3d n = shape.area / size;
    const Vector3d bar_n = bar.n + bar.d * shape.middle;
    const Vector3d bar_area = (bar_n - n.dot(bar_n) * n) / size;
    const Vector3d bar_corner = bar.d / (3.0 * static_cast<double>(faces[i].size())) * n;
    for (const Vector3i& t : faces[i]) {
      const std::array<Vector3d, 3> x = GetCorners(t, pieces.vertices);
      for (std::size_t k = 0; k < 3; ++k) {
        bar_vertices->col(t[static_cast<Eigen::Index>(k)]) +=
            0.5 * (x[(k + 1) % 3] - x[(k + 2) % 3]).cross(bar_area) + bar_corner;
      }
    }
  }
}

}  // namespace knap
