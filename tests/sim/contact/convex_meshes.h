// Convex meshes for tests of contact.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "sim/geometry/triangle_mesh.h"

namespace knap::test {

// A prism with a triangle for its ends, 20 mm long.
inline TriangleMesh MakeWedge() {
  TriangleMesh wedge;
  wedge.vertices = {{-0.008, -0.01, -0.004}, {0.008, -0.01, -0.004}, {0.0, -0.01, 0.006},
                    {-0.008, 0.01, -0.004},  {0.008, 0.01, -0.004},  {0.0, 0.01, 0.006}};
  wedge.triangles = {{0, 1, 2}, {5, 4, 3}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  return wedge;
}

// A pyramid on a rectangle, with its tip off the middle.
inline TriangleMesh MakePyramid() {
  TriangleMesh pyramid;
  pyramid.vertices = {{-0.009, -0.007, -0.003},
                      {0.008, -0.007, -0.003},
                      {0.008, 0.008, -0.003},
                      {-0.009, 0.008, -0.003},
                      {0.002, -0.001, 0.009}};
  pyramid.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return pyramid;
}

// A box of twelve triangles.
inline TriangleMesh MakeBoxMesh(const Eigen::Vector3d& half, const Eigen::Vector3d& center) {
  TriangleMesh box;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
    box.vertices.push_back(center + corner.cwiseProduct(half));
  }
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

// An octahedron whose triangles are split into four, again and again, all corners on a sphere: 8, 32, 128, … faces.
inline TriangleMesh MakeRoundHull(double radius, int splits) {
  TriangleMesh mesh;
  for (const double s : {1.0, -1.0}) {
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(s * Eigen::Vector3d::Unit(i));
  }
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (int k = 0; k < splits; ++k) {
    std::map<std::pair<int, int>, int> middles;
    const auto split = [&](int a, int b) {
      const auto [at, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const int ab = split(t[0], t[1]);
      const int bc = split(t[1], t[2]);
      const int ca = split(t[2], t[0]);
      for (const Eigen::Vector3i& part : {Eigen::Vector3i(t[0], ab, ca), Eigen::Vector3i(ab, t[1], bc),
                                          Eigen::Vector3i(ca, bc, t[2]), Eigen::Vector3i(ab, bc, ca)}) {
        finer.push_back(part);
      }
    }
    mesh.triangles = finer;
  }
  for (Eigen::Vector3d& x : mesh.vertices) x *= radius;
  return mesh;
}

}  // namespace knap::test
