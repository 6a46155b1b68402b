# Every package knap uses becomes one imported target here, whatever form its distribution gives it.
include(KnapSimDependencies)
find_package(Threads REQUIRED)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)

# LCM 1.3.1 ships no CMake package, newer ones do.
pkg_check_modules(LCM QUIET lcm)  # for its version
find_package(lcm QUIET)
if(TARGET lcm::lcm)
  add_library(knap_dep_lcm INTERFACE)
  target_link_libraries(knap_dep_lcm INTERFACE lcm::lcm)
else()
  find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp REQUIRED)
  find_library(LCM_LIBRARY lcm REQUIRED)
  add_library(knap_dep_lcm INTERFACE)
  target_include_directories(knap_dep_lcm SYSTEM INTERFACE ${LCM_INCLUDE_DIR})
  target_link_libraries(knap_dep_lcm INTERFACE ${LCM_LIBRARY})
endif()
find_program(LCM_GEN lcm-gen REQUIRED)

pkg_check_modules(NLOPT REQUIRED IMPORTED_TARGET nlopt)
find_path(NLOPT_CXX_INCLUDE_DIR nlopt.hpp REQUIRED)
find_library(NLOPT_CXX_LIBRARY NAMES nlopt_cxx nlopt REQUIRED)
add_library(knap_dep_nlopt INTERFACE)
target_include_directories(knap_dep_nlopt SYSTEM INTERFACE ${NLOPT_CXX_INCLUDE_DIR})
target_link_libraries(knap_dep_nlopt INTERFACE ${NLOPT_CXX_LIBRARY} PkgConfig::NLOPT)

pkg_check_modules(URDF REQUIRED IMPORTED_TARGET urdfdom)
add_library(knap_dep_urdf INTERFACE)
target_link_libraries(knap_dep_urdf INTERFACE PkgConfig::URDF)

pkg_check_modules(SODIUM REQUIRED IMPORTED_TARGET libsodium)
add_library(knap_dep_sodium INTERFACE)
target_link_libraries(knap_dep_sodium INTERFACE PkgConfig::SODIUM)

pkg_check_modules(HTTPLIB REQUIRED IMPORTED_TARGET cpp-httplib)
