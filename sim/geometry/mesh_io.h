#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Reads a mesh from the bytes of an OBJ or STL (binary or text) file, told apart by the ending of `name`
// in any case; coordinates are multiplied by `metres_per_unit` (0.001 for files in millimetres).
//
// Vertices with equal coordinates become one, and triangles that lose a corner by it vanish. OBJ: vertices
// keep the order and, where none coincide, the numbers of the file's `v` lines (from 0), also those that no
// face uses; polygons are split into triangles (polygon.h). STL: order of first use. Texts are read at full
// double precision. Texture coordinates, normals, colours, groups and materials are ignored; no other file
// is opened. Which dialects are read is in mesh_text.h; a binary STL may have more bytes behind its facets.
//
// The mesh may be open or badly oriented; see FindDefects. Bytes may come from anyone.
//
// Throws std::runtime_error with one line that starts with `name`, and with the line and column of a text
// file: "cage.obj:12:3: vertex 9 does not exist: the file has 8, counted from 1".
TriangleMesh ReadMesh(const std::string& name, std::string_view bytes, double metres_per_unit);

// Returns a binary STL file in millimetres of a mesh in metres, single precision, with each triangle's unit
// normal. Equal vertices stay equal, so a closed mesh stays closed. Indices must be in range. Throws
// std::runtime_error when the volume is not positive: nobody can print such a file.
std::string WriteStl(const TriangleMesh& mesh);

// Returns an OBJ file of a mesh in metres, with coordinates divided by `metres_per_unit` and written with
// nine digits. Vertices and triangles keep their order, so that what names a vertex by its number (a cage's
// groups) is true of the file. Indices must be in range.
std::string WriteObj(const TriangleMesh& mesh, double metres_per_unit);

// Writes `bytes` to `path`, replacing what was there. Throws std::runtime_error with path and reason.
void WriteFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace knap
