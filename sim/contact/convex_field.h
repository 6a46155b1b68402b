// The depth field of a mesh that is convex, with a plane for each of its faces.
#pragma once

#include <optional>
#include <vector>

#include "sim/contact/contact_shape.h"
#include "sim/contact/depth_field.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

// A face and the triangles that lie in it: its plane is that of the largest.
struct ConvexFace {
  FieldPlane plane;
  std::vector<int> triangles;
};

// `mesh` bounds one or several bodies (FindDefects is empty). Convex is one whose vertices all lie on or below the
// plane of every facet, up to 1e-6 of its size: files in single precision round to a tenth of that. Facets whose
// corners lie in a plane already taken, to the same 1e-6, are of one face.
//
// Empty where the mesh is not convex, or has more than kMostFaces faces: every face is a patch with a law of friction
// of its own.
inline constexpr int kMostFaces = 1000;
std::optional<std::vector<ConvexFace>> FindConvexFaces(const TriangleMesh& mesh);
std::optional<PolyhedralField> MakeConvexField(const TriangleMesh& mesh);

// Bounds and deepest place of a field from its planes; its bounds must be around it roughly. False where the planes
// hold nothing, or more than ten times as much.
bool FitBounds(PolyhedralField* field);

// What a body touches with that has such a mesh, which no design shapes; empty likewise.
std::optional<MeshGeometry> MakeConvexMesh(const TriangleMesh& mesh);

}  // namespace knap
