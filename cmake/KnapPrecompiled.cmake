# Headers that many sources include are compiled once, for parsing them took most of the compiler's time. No header of
# knap's own is among them, and every source still includes what it uses: with -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
# (what clang-tidy needs, see CONTRIBUTING.md) the same build works without them.

# knap_precompile(NAME HEADERS <a> … [DEPS …]): a set for knap_use_precompiled(TARGET NAME).
function(knap_precompile name)
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPS" ${ARGN})
  # The set belongs to a target, and a target has a source.
  set(nothing ${PROJECT_BINARY_DIR}/precompiled_${name}.cc)
  file(CONFIGURE OUTPUT ${nothing} CONTENT "// nothing but the precompiled headers\n")
  add_library(knap_precompiled_${name} OBJECT ${nothing})
  target_link_libraries(knap_precompiled_${name} PRIVATE ${ARG_DEPS} knap_settings)
  target_precompile_headers(knap_precompiled_${name} PRIVATE ${ARG_HEADERS})
endfunction()

function(knap_use_precompiled target name)
  target_precompile_headers(${target} REUSE_FROM knap_precompiled_${name})
endfunction()

set(knap_common_headers
  <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <mutex> <optional> <set>
  <span> <sstream> <stdexcept> <string> <thread> <unordered_map> <utility> <vector> <Eigen/Dense> <fmt/format.h>)
knap_precompile(common HEADERS ${knap_common_headers} DEPS Eigen3::Eigen)
# For what talks to the user or writes documents.
knap_precompile(commands HEADERS ${knap_common_headers} <CLI/CLI.hpp> <nlohmann/json.hpp>
  DEPS Eigen3::Eigen CLI11::CLI11 nlohmann_json::nlohmann_json)
