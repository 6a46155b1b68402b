// The text formats of meshes: what an OBJ or text STL file says about its surface.
//
// A byte order mark at the beginning is passed over, and lines end with LF, CR LF or CR alone. Both functions throw
// std::runtime_error "name:line:column: …" (counted from 1). Coordinates must be finite and within ±1e9.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

struct ObjPolygon {
  int line = 0;              // of the file, on which its `f` stands
  std::vector<int> corners;  // at least three indices into vertices, all valid
};

struct ObjSurface {
  std::vector<Eigen::Vector3d> vertices;  // one per `v` line, in the file's units
  std::vector<ObjPolygon> polygons;       // one per `f` line
};

// Parses the `v` and `f` lines of an OBJ file [Wavefront 1995]; faces may come before their vertices, and a line that
// ends with `\` goes on in the next. Statements that say nothing about a surface of polygons are passed over; those of
// free-form surfaces and of other files to be read are refused, because something would be missing.
ObjSurface ParseObjSurface(const std::string& name, std::string_view text);

// Parses a text STL: solids of facets of one loop of three vertices, the keywords in capitals or not, with any white
// space in between. Several solids are read as one. What follows the last `endsolid` is passed over. Every triangle has
// vertices of its own.
TriangleMesh ParseTextStl(const std::string& name, std::string_view text);

// Whether the text begins, behind a mark and white space, with `solid` in capitals or not.
bool BeginsAsTextStl(std::string_view text);

}  // namespace knap
