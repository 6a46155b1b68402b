# Headers that many sources include are compiled once, for parsing them took most of the compiler's time. No header of
# knap's own is among them, and every source still includes what it uses: with -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
# (what clang-tidy needs, see CONTRIBUTING.md) the same build works without them.

# knap_precompile(NAME [LIGHT] HEADERS <a> … [DEPS …]): a set for knap_use_precompiled(TARGET NAME).
# What uses a LIGHT set is optimised lightly: it prints, parses and compares, which waits for nothing, and optimising
# that took two thirds of the time that compiling it took. Libraries that it calls have their own flags.
function(knap_precompile name)
  cmake_parse_arguments(ARG "LIGHT" "" "HEADERS;DEPS" ${ARGN})
  # The set belongs to a target, and a target has a source.
  set(nothing ${PROJECT_BINARY_DIR}/precompiled_${name}.cc)
  file(CONFIGURE OUTPUT ${nothing} CONTENT "// nothing but the precompiled headers\n")
  add_library(knap_precompiled_${name} OBJECT ${nothing})
  target_link_libraries(knap_precompiled_${name} PRIVATE ${ARG_DEPS} knap_settings)
  target_precompile_headers(knap_precompiled_${name} PRIVATE ${ARG_HEADERS})
  if(ARG_LIGHT)
    set_target_properties(knap_precompiled_${name} PROPERTIES KNAP_LIGHT_OPTIONS "$<$<NOT:$<CONFIG:Debug>>:-O1>")
    knap_optimise_like(knap_precompiled_${name} ${name})
  endif()
endfunction()

# A precompiled header is of use to what is compiled with its own flags alone.
function(knap_optimise_like target name)
  get_target_property(light knap_precompiled_${name} KNAP_LIGHT_OPTIONS)
  if(light)
    target_compile_options(${target} PRIVATE ${light})
  endif()
endfunction()

function(knap_use_precompiled target name)
  target_precompile_headers(${target} REUSE_FROM knap_precompiled_${name})
  knap_optimise_like(${target} ${name})
endfunction()

set(knap_common_headers
  <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <mutex> <optional> <set>
  <span> <sstream> <stdexcept> <string> <thread> <unordered_map> <utility> <vector> <Eigen/Dense> <fmt/format.h>)
knap_precompile(common HEADERS ${knap_common_headers} DEPS Eigen3::Eigen)
# For what reads and writes documents.
knap_precompile(documents LIGHT HEADERS ${knap_common_headers} <nlohmann/json.hpp>
  DEPS Eigen3::Eigen nlohmann_json::nlohmann_json)
# For what talks to the user. CLI11's functions are compiled anew by everyone, which takes five seconds.
knap_precompile(commands LIGHT HEADERS ${knap_common_headers} <CLI/CLI.hpp> <nlohmann/json.hpp>
  DEPS Eigen3::Eigen CLI11::CLI11 nlohmann_json::nlohmann_json)
