#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace knap {

// What an OBJ file says about its surface.
struct ObjSurface {
  std::vector<Eigen::Vector3d> vertices;   // one per `v` line, in the file's units
  std::vector<std::vector<int>> polygons;  // one per `f` line: at least three indices into vertices, all valid
};

// Parses the `v` and `f` lines of an OBJ file and ignores other known keywords. Coordinates must be finite
// and within +-1e9. Throws std::runtime_error "name:line:column: …" (counted from 1).
ObjSurface ParseObjSurface(const std::string& name, std::string_view text);

// Checks that `text` is a complete text STL: solid, facets of one loop of three finite vertices, endsolid.
// Throws std::runtime_error "name:line:column: …" (counted from 1).
void CheckTextStl(const std::string& name, std::string_view text);

}  // namespace knap
