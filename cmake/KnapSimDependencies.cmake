# What the simulator uses. Installed too: the package `knap` includes it before its targets, which name these.
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(fmt REQUIRED)

# Bullet exists in two precisions; the headers follow BT_USE_DOUBLE_PRECISION and must match the library.
pkg_check_modules(BULLET_FLOAT64 REQUIRED IMPORTED_TARGET bullet-float64)
add_library(knap_dep_bullet INTERFACE IMPORTED)
target_link_libraries(knap_dep_bullet INTERFACE PkgConfig::BULLET_FLOAT64)
target_compile_definitions(knap_dep_bullet INTERFACE BT_USE_DOUBLE_PRECISION)
# Of Bullet's extras, without a pkg-config file; it computes in doubles in either precision.
find_path(HACD_INCLUDE_DIR HACD/hacdHACD.h PATH_SUFFIXES bullet REQUIRED)
find_library(HACD_LIBRARY NAMES HACD-float64 HACD REQUIRED)
add_library(knap_dep_hacd INTERFACE IMPORTED)
target_include_directories(knap_dep_hacd SYSTEM INTERFACE ${HACD_INCLUDE_DIR})
target_link_libraries(knap_dep_hacd INTERFACE ${HACD_LIBRARY})

pkg_check_modules(QHULL REQUIRED IMPORTED_TARGET qhull_r)
add_library(knap_dep_qhull INTERFACE IMPORTED)
target_link_libraries(knap_dep_qhull INTERFACE PkgConfig::QHULL)

pkg_check_modules(ASSIMP REQUIRED IMPORTED_TARGET assimp)
add_library(knap_dep_assimp INTERFACE IMPORTED)
target_link_libraries(knap_dep_assimp INTERFACE PkgConfig::ASSIMP)
