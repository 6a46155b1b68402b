// The shells of a mesh, its pieces connected over edges, and how they lie in each other.
//
// A body may consist of several solids that are apart, and a solid may have cavities. Its mesh then has a shell for
// each solid, facing outwards, and inside it one for each cavity, facing inwards, that is, away from the material.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

struct Shell {
  std::vector<int> triangles;  // ascending
  Eigen::AlignedBox3d box;     // [m]
  double volume = 0.0;         // [m³], negative when it faces inwards
};

// In the order of their first triangles. Every edge has two triangles, indices are in range.
std::vector<Shell> FindShells(const TriangleMesh& mesh);

// "part 2 of 3 (12 triangles, from (8, -5, 0) to (20, 5, 12) mm)"; `index` from 0.
std::string DescribeShell(const std::vector<Shell>& shells, int index);

// Why the first shell that is neither the outside of a solid nor a cavity is none, one line without a full stop; empty
// when all are. No two shells meet (self_contact.h).
std::string FindWrongShell(const TriangleMesh& mesh, const std::vector<Shell>& shells);

}  // namespace knap
