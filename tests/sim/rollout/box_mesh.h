// A box as the text of an OBJ file.
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

}  // namespace knap::test
