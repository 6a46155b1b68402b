# Much of compiling is templates, made anew for every source: a target's sources are compiled eight at a time. Preset
# dev has this off, for whoever changes one source and builds again.
option(KNAP_UNITY "Compile a target's sources several at a time" ON)
set(CMAKE_UNITY_BUILD ${KNAP_UNITY})

# One interface target holds every private compile setting of knap's own code.
add_library(knap_settings INTERFACE)
target_compile_options(knap_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast
  # The same source gives the same bits: no contraction into fused operations, whatever the compiler's default.
  -ffp-contract=off
  # What a failed CHECK prints is a path in the tree, wherever the tree was.
  -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=
  # Where sources are compiled together, what a class and its source keep to themselves looks as if it were a header's.
  $<$<AND:$<BOOL:${KNAP_UNITY}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>
  # Lets ccache see what a precompiled header holds.
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
# fmt's header is among the precompiled ones, so its definitions must be the same everywhere.
target_link_libraries(knap_settings INTERFACE fmt::fmt)
if(KNAP_SANITIZE)
  foreach(sanitizer IN LISTS KNAP_SANITIZE)
    target_compile_options(knap_settings INTERFACE -fsanitize=${sanitizer})
    target_link_options(knap_settings INTERFACE -fsanitize=${sanitizer})
  endforeach()
  target_compile_options(knap_settings INTERFACE -fno-omit-frame-pointer)
  if("undefined" IN_LIST KNAP_SANITIZE)
    # GCC 12 crashes on LCM's member-function handlers with the vptr check.
    target_compile_options(knap_settings INTERFACE -fno-sanitize=vptr -fno-sanitize-recover=undefined)
  endif()
endif()

# Of the folder that calls it and those it adds after: under sanitizers Clang stops inlining Eigen, and what computes is
# four times as slow. Elsewhere it would only take three times as long to compile.
macro(knap_inline_eigen)
  if(KNAP_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    add_compile_options("SHELL:-mllvm -inline-threshold=5000")
  endif()
endmacro()

include(KnapPrecompiled)

# knap_library(NAME SOURCES a.cc … [DEPS …] [PRIVATE_DEPS …] [PRECOMPILED set])
# A static library knap_NAME with alias knap::NAME; headers are included from the root of the tree.
function(knap_library name)
  cmake_parse_arguments(ARG "" "PRECOMPILED" "SOURCES;DEPS;PRIVATE_DEPS" ${ARGN})
  if(NOT ARG_PRECOMPILED)
    set(ARG_PRECOMPILED common)
  endif()
  add_library(knap_${name} STATIC ${ARG_SOURCES})
  add_library(knap::${name} ALIAS knap_${name})
  target_include_directories(knap_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/knap>)
  target_link_libraries(knap_${name} PUBLIC ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS} $<BUILD_INTERFACE:knap_settings>)
  knap_use_precompiled(knap_${name} ${ARG_PRECOMPILED})
endfunction()

# knap_executable(NAME OUTPUT program SOURCES a.cc … DEPS …)
function(knap_executable name)
  cmake_parse_arguments(ARG "" "OUTPUT" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} knap_settings)
  if(ARG_OUTPUT)
    set_target_properties(${name} PROPERTIES OUTPUT_NAME ${ARG_OUTPUT})
  endif()
endfunction()

# [s] There to end what hangs, however busy or slow the machine: no test takes a tenth of it on two idle cores.
# Sanitizers slow numerical code down by five to ten times.
set(knap_test_limit 1800)
if(KNAP_SANITIZE)
  math(EXPR knap_test_limit "${knap_test_limit} * 10")
endif()

# knap_test_program(NAME DEPS … [DEFINITIONS …]): a GoogleTest program for a folder's tests, which knap_test(… IN NAME)
# fills. Compiled together they share their templates: each source has a namespace of its own, named after it.
function(knap_test_program name)
  cmake_parse_arguments(ARG "" "" "DEPS;DEFINITIONS" ${ARGN})
  add_executable(${name})
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} GTest::gmock GTest::gtest_main knap_settings)
  target_compile_definitions(${name} PRIVATE ${ARG_DEFINITIONS})
  knap_use_precompiled(${name} tests)
endfunction()

# The GoogleTest filter for all tests of some sources, read off them.
function(knap_make_test_filter out)
  set(suites "")
  foreach(source IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} lines REGEX "^(TYPED_)?TEST(_F|_P)?\\(|^RC_GTEST_(FIXTURE_)?PROP\\(")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^[A-Z_]+\\(([A-Za-z0-9_]+).*" "\\1" suite "${line}")
      list(APPEND suites ${suite})
    endforeach()
  endforeach()
  if(NOT suites)
    message(FATAL_ERROR "no tests in ${ARGN}")
  endif()
  list(REMOVE_DUPLICATES suites)
  list(TRANSFORM suites REPLACE "(.+)" "\\1.*:*/\\1.*:\\1/*:*/\\1/*")
  list(JOIN suites ":" filter)
  set(${out} ${filter} PARENT_SCOPE)
endfunction()

# knap_test(NAME SOURCES a_test.cc … [DEPS … | IN program] [LABELS …]): one CTest entry; a GoogleTest program by itself,
# or a part of one of knap_test_program.
function(knap_test name)
  cmake_parse_arguments(ARG "" "IN" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  if(ARG_IN)
    target_sources(${ARG_IN} PRIVATE ${ARG_SOURCES})
    knap_make_test_filter(filter ${ARG_SOURCES})
    add_test(NAME ${name} COMMAND ${ARG_IN} --gtest_filter=${filter})
  else()
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_DEPS} GTest::gmock GTest::gtest_main knap_settings)
    knap_use_precompiled(${name} tests)
    add_test(NAME ${name} COMMAND ${name})
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${knap_test_limit})
endfunction()

# knap_script_test(NAME COMMAND script arguments… LABELS …): a script that starts real processes. It may end with
# 77: skipped, having said why.
function(knap_script_test name)
  cmake_parse_arguments(ARG "" "" "COMMAND;LABELS" ${ARGN})
  add_test(NAME ${name} COMMAND ${ARG_COMMAND})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${knap_test_limit} SKIP_RETURN_CODE 77)
endfunction()
