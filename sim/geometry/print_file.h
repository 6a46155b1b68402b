// Files of a mesh for printers and viewers.
//
//   stl  binary; each triangle with its own corners and normal; has no unit, slicers take millimetres
//   3mf  the package of [3MF Core 1.3], with its unit; what slicers like best
//   obj  text, in millimetres
//   glb  binary glTF 2.0, which is in metres and has y up: a node turns the mesh, whose z is up
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

enum class PrintFormat { kStl, k3mf, kObj, kGlb };

// "stl", "3mf", "obj" or "glb": a format's name, and the ending of its files.
std::string_view GetName(PrintFormat format);
std::optional<PrintFormat> FindPrintFormat(std::string_view name);

// What a file holds of a mesh in metres: its coordinates, in the file's unit, are rounded to single precision. A check
// of this mesh is one of the file.
TriangleMesh RoundAsWritten(const TriangleMesh& mesh, PrintFormat format);

// The bytes of a file of a mesh in metres. Indices must be in range. `name` of the object, plain text. Throws
// std::runtime_error when the volume is not positive: nobody can print such a file.
std::string WritePrintFile(const TriangleMesh& mesh, PrintFormat format, const std::string& name);

}  // namespace knap
