# What `cmake --install` puts where, the CMake package `knap`, and a Debian package by CPack (docs/install.md).
include(CMakePackageConfigHelpers)

set(knap_share ${CMAKE_INSTALL_DATADIR}/knap)
# knap starts the workers that lie beside it.
install(TARGETS knap_program knap_worker_executable knap_relay RUNTIME)
install(DIRECTORY configs/ DESTINATION ${knap_share}/configs)
install(DIRECTORY lcmtypes/ DESTINATION ${knap_share}/lcmtypes FILES_MATCHING PATTERN "*.lcm" PATTERN program EXCLUDE
  PATTERN wire EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/bin/knap_types.jar DESTINATION ${knap_share} OPTIONAL)  # with a JDK alone
install(DIRECTORY worker/python/ ${PROJECT_BINARY_DIR}/bin/python/ DESTINATION ${knap_share}/python
  FILES_MATCHING PATTERN "*.py")
install(FILES README.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN man EXCLUDE)
install(DIRECTORY docs/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 FILES_MATCHING PATTERN "*.1")
install(FILES coordinator/cli/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME knap)

# knap::sim, the simulator without the cluster: all of sim/, by its headers as they include one another.
add_library(knap_sim INTERFACE)
add_library(knap::sim ALIAS knap_sim)
target_link_libraries(knap_sim INTERFACE knap_sim_rollout knap_sim_transfer)
set_target_properties(knap_sim PROPERTIES EXPORT_NAME sim)
set(knap_sim_libraries
  geometry morphology sim_contact sim_contact_geometry sim_gradient sim_integrators sim_math sim_multibody sim_policy
  sim_rollout sim_scenarios sim_signals sim_transfer)
list(TRANSFORM knap_sim_libraries PREPEND knap_)
install(TARGETS knap_sim ${knap_sim_libraries} EXPORT knap_targets ARCHIVE)
install(DIRECTORY sim DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/knap FILES_MATCHING PATTERN "*.h")
set(knap_package ${CMAKE_INSTALL_LIBDIR}/cmake/knap)
install(EXPORT knap_targets NAMESPACE knap:: FILE knapTargets.cmake DESTINATION ${knap_package})
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/knapConfig.cmake CONTENT [[
# find_package(knap): the target knap::sim.
include(CMakeFindDependencyMacro)
include(${CMAKE_CURRENT_LIST_DIR}/KnapSimDependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/knapTargets.cmake)
]] @ONLY)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/knapConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/knapConfig.cmake ${PROJECT_BINARY_DIR}/knapConfigVersion.cmake
  cmake/KnapSimDependencies.cmake DESTINATION ${knap_package})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME knap)
set(CPACK_PACKAGE_VENDOR "knap authors")
set(CPACK_PACKAGE_CONTACT "knap authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "liblcm-bin")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "liblcm-java, python3")
include(CPack)
