// A box as the text of an OBJ file, and the design of one whose side moves.
#pragma once

#include <string>
#include <utility>

namespace knap::test {

// Its vertices 4 to 7 (from 0) are those at x1.
inline std::string MakeBoxObj(int x0, int x1, int y0, int y1, int z0, int z1) {
  std::string text;
  for (const int x : {x0, x1}) {
    for (const auto& [y, z] : {std::pair{y0, z0}, {y1, z0}, {y1, z1}, {y0, z1}}) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    }
  }
  for (const char* face :
       {"1 3 2", "1 4 3", "5 6 7", "5 7 8", "1 2 6", "1 6 5", "4 8 7", "4 7 3", "2 3 7", "2 7 6", "1 5 8", "1 8 4"}) {
    text.append("f ").append(face).append("\n");
  }
  return text;
}

// Ends the scene of a body `tool` that touches with the mesh box.obj in the cage cage.obj, both of MakeBoxObj and 40 mm
// wide: the side at x1 moves.
inline constexpr char kBoxDesign[] = R"(design:
  parameters: [{name: width, initial: 40 mm, lower: 30 mm, upper: 50 mm}]
  bodies:
    - name: tool
      mesh: box.obj
      cage: cage.obj
      mesh_unit: 1 mm
      vertex_groups: [{name: right, vertices: [4, 5, 6, 7]}]
      moves: [{parameter: width, group: right, direction: [1, 0, 0]}]
)";

}  // namespace knap::test
