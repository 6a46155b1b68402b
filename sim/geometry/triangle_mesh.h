#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace knap {

// A surface of triangles, in metres, in whatever frame its owner says. A triangle names its corners
// counter-clockwise as seen from outside, so (b - a) x (c - a) points out of the body.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;   // [m]
  std::vector<Eigen::Vector3i> triangles;  // indices into vertices
};

// What keeps a mesh from being the boundary of a body: counts, and one example of the worst kind.
struct MeshDefects {
  int bad_indices = 0;           // triangles naming a vertex that does not exist
  int non_finite_vertices = 0;   // vertices with a NaN or an infinity
  int degenerate_triangles = 0;  // a corner repeated, or area below 1e-12 of the longest edge squared
  int repeated_triangles = 0;    // triangles with the corners of an earlier one: a part that is there twice
  int open_edges = 0;            // edges with one triangle
  int non_manifold_edges = 0;    // edges with more than two triangles
  int flipped_edges = 0;         // edges whose two triangles disagree on which side is outside
  int unused_vertices = 0;       // vertices without a triangle
  bool meets_itself = false;     // so far sound, but two triangles meet beyond the corners they share
  bool wrong_shells = false;     // so far sound, but a shell is neither the outside of a solid nor a cavity (shells.h)
  bool inside_out = false;       // otherwise sound, but the volume is not positive
  std::string example;           // for instance "edge 3-7 has only one triangle"
  std::optional<Eigen::Vector3d> place{};  // of the example [m]; none where all of the mesh is meant

  bool empty() const;
  // One line, "2 open edges, 1 flipped edge (edge 3-7 has only one triangle)"; "" when empty().
  std::string Describe() const;
};

// Finds everything that keeps `mesh` from being the boundary of solids that are apart, with or without cavities:
// closed, manifold at its edges, without self-contact, every shell oriented away from the material. Any content is
// allowed, also indices out of range. An empty mesh is inside_out (it bounds no volume).
MeshDefects FindDefects(const TriangleMesh& mesh);

// The volume [m^3] enclosed by a closed mesh, by the divergence theorem: a sixth of the sum of
// a . (b x c) over the triangles, taken about the centre of the bounding box to save digits. Negative
// when inside out; without meaning when open. Indices must be in range.
double CalcSignedVolume(const TriangleMesh& mesh);

// The smallest box around the vertices, in their frame; empty (isEmpty()) for a mesh without any.
Eigen::AlignedBox3d CalcBoundingBox(const TriangleMesh& mesh);

}  // namespace knap
