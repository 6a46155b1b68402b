# Every package knap uses becomes one imported target here, whatever form its distribution gives it.
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)

# LCM 1.3.1 ships no CMake package, newer ones do.
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

# Bullet exists in two precisions; the headers follow BT_USE_DOUBLE_PRECISION and must match the library.
pkg_check_modules(BULLET_FLOAT64 REQUIRED IMPORTED_TARGET bullet-float64)
add_library(knap_dep_bullet INTERFACE)
target_link_libraries(knap_dep_bullet INTERFACE PkgConfig::BULLET_FLOAT64)
target_compile_definitions(knap_dep_bullet INTERFACE BT_USE_DOUBLE_PRECISION)
# Of Bullet's extras, without a pkg-config file; it computes in doubles in either precision.
find_path(HACD_INCLUDE_DIR HACD/hacdHACD.h PATH_SUFFIXES bullet REQUIRED)
find_library(HACD_LIBRARY NAMES HACD-float64 HACD REQUIRED)
add_library(knap_dep_hacd INTERFACE)
target_include_directories(knap_dep_hacd SYSTEM INTERFACE ${HACD_INCLUDE_DIR})
target_link_libraries(knap_dep_hacd INTERFACE ${HACD_LIBRARY})

pkg_check_modules(QHULL REQUIRED IMPORTED_TARGET qhull_r)
add_library(knap_dep_qhull INTERFACE)
target_link_libraries(knap_dep_qhull INTERFACE PkgConfig::QHULL)

pkg_check_modules(NLOPT REQUIRED IMPORTED_TARGET nlopt)
find_path(NLOPT_CXX_INCLUDE_DIR nlopt.hpp REQUIRED)
find_library(NLOPT_CXX_LIBRARY NAMES nlopt_cxx nlopt REQUIRED)
add_library(knap_dep_nlopt INTERFACE)
target_include_directories(knap_dep_nlopt SYSTEM INTERFACE ${NLOPT_CXX_INCLUDE_DIR})
target_link_libraries(knap_dep_nlopt INTERFACE ${NLOPT_CXX_LIBRARY} PkgConfig::NLOPT)

pkg_check_modules(ASSIMP REQUIRED IMPORTED_TARGET assimp)
add_library(knap_dep_assimp INTERFACE)
target_link_libraries(knap_dep_assimp INTERFACE PkgConfig::ASSIMP)

pkg_check_modules(URDF REQUIRED IMPORTED_TARGET urdfdom)
add_library(knap_dep_urdf INTERFACE)
target_link_libraries(knap_dep_urdf INTERFACE PkgConfig::URDF)

pkg_check_modules(SODIUM REQUIRED IMPORTED_TARGET libsodium)
add_library(knap_dep_sodium INTERFACE)
target_link_libraries(knap_dep_sodium INTERFACE PkgConfig::SODIUM)
