// A mesh as a 3MF package: a ZIP archive, whose files are stored as they are, of one model in millimetres.
//
// Not by assimp, whose exporter writes six digits, and the time of day, to a file of its own.
#pragma once

#include <string>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// `mesh` in metres, indices in range; coordinates have single precision. The same bytes for the same mesh.
// Source: [3MF Core 1.3], [ECMA-376-2] for the package, [APPNOTE 6.3] for the archive.
std::string Write3mf(const TriangleMesh& mesh, const std::string& name);

}  // namespace knap
