#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/geometry/mesh_io.h"

namespace knap::test {

// The message of what ReadMesh throws, "" if it does not.
inline std::string ReadError(const std::string& name, std::string_view bytes, double unit = 1) {
  try {
    ReadMesh(name, bytes, unit);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace knap::test
