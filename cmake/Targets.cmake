# scanknit_flags(target): warnings, and arithmetic that gives the same bits on every machine.
function(scanknit_flags target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wconversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast
    -ffp-contract=off -fno-semantic-interposition
    # False alarms of GCC 12 inside std::string (its bug 105651), which come through once headers are precompiled.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds> $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>
    $<$<BOOL:${SCANKNIT_WERROR}>:-Werror>)
endfunction()

# What nearly every source includes: half of the time that the compiler takes. Compiled once for all rooms, and once
# more for the sources that include OpenVDB, whose headers cost each of them another second or two.
set(SCANKNIT_PRECOMPILED
  <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <chrono> <cmath> <condition_variable> <filesystem> <fstream> <functional> <map>
  <memory> <mutex> <optional> <span> <sstream> <stop_token> <string> <string_view> <thread> <variant> <vector>)

foreach(name headers headers_openvdb)
  add_library(scanknit_${name} OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_compile_features(scanknit_${name} PRIVATE cxx_std_20)
  target_link_libraries(scanknit_${name} PRIVATE Eigen3::Eigen)
  target_precompile_headers(scanknit_${name} PRIVATE ${SCANKNIT_PRECOMPILED})
  scanknit_flags(scanknit_${name})
endforeach()
target_link_libraries(scanknit_headers_openvdb PRIVATE OpenVDB::openvdb)
target_precompile_headers(scanknit_headers_openvdb PRIVATE <openvdb/openvdb.h>)

# scanknit_apart(sources...): a unity build does not join those of them that Highway includes once for each instruction set.
function(scanknit_apart)
  foreach(source ${ARGN})
    file(STRINGS ${source} again REGEX "hwy/foreach_target.h" LIMIT_COUNT 1)
    if(again)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()

# scanknit_openvdb_sources(target sources...): adds sources that include OpenVDB, be it through other headers, to a
# target whose other sources do not.
function(scanknit_openvdb_sources target)
  set(objects ${target}_openvdb)
  add_library(${objects} OBJECT ${ARGN})
  scanknit_apart(${ARGN})
  target_compile_features(${objects} PRIVATE cxx_std_20)
  target_include_directories(${objects} PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
  target_link_libraries(${objects} PRIVATE OpenVDB::openvdb $<TARGET_PROPERTY:${target},LINK_LIBRARIES>)
  target_precompile_headers(${objects} REUSE_FROM scanknit_headers_openvdb)
  scanknit_flags(${objects})
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
endfunction()

# scanknit_room(name SOURCES ... [OPENVDB_SOURCES ...] [HEADERS ...] PUBLIC ... PRIVATE ... [PRECOMPILE headers]): the library
# ScanKnit::name, whose headers are included as "name/header.h". HEADERS are the public ones: Install.cmake installs
# them, and no others. They include no header of ours that is not public.
function(scanknit_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;OPENVDB_SOURCES;HEADERS;PUBLIC;PRIVATE;PRECOMPILE" ${ARGN})
  list(TRANSFORM ROOM_HEADERS PREPEND ${name}/)
  set_property(GLOBAL APPEND PROPERTY SCANKNIT_HEADERS ${ROOM_HEADERS})
  set(target scanknit_${name})
  if(TARGET ScanKnit::${name})  # a project around this one brings it
    return()
  endif()
  add_library(${target} ${ROOM_SOURCES})
  scanknit_apart(${ROOM_SOURCES})
  add_library(ScanKnit::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/scanknit>)
  target_link_libraries(${target} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  if(ROOM_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${SCANKNIT_PRECOMPILED} ${ROOM_PRECOMPILE})
  else()
    target_precompile_headers(${target} REUSE_FROM scanknit_headers)
  endif()
  scanknit_flags(${target})
  if(ROOM_OPENVDB_SOURCES)
    scanknit_openvdb_sources(${target} ${ROOM_OPENVDB_SOURCES})
  endif()
  set_property(GLOBAL APPEND PROPERTY SCANKNIT_ROOMS ${target})
endfunction()

# scanknit_module(name SOURCES ... LIBRARIES ... [COMPONENT component]): libscanknit_name.so, which core/system/module.h opens when
# it is asked for. No library to link with, and so installed in a folder of its own. The program is built with all of
# them; a test that needs one has add_dependencies(test scanknit_name).
function(scanknit_module name)
  cmake_parse_arguments(MODULE "" "COMPONENT" "SOURCES;LIBRARIES" ${ARGN})
  set(target scanknit_${name})
  if(NOT MODULE_COMPONENT)
    set(MODULE_COMPONENT runtime)
  endif()
  add_library(${target} MODULE ${MODULE_SOURCES})
  target_link_libraries(${target} PRIVATE ${MODULE_LIBRARIES})
  scanknit_flags(${target})
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/scanknit COMPONENT ${MODULE_COMPONENT})
  set_property(GLOBAL APPEND PROPERTY SCANKNIT_MODULES ${target})
endfunction()

# scanknit_test(name SOURCES ... LIBRARIES ... [LABEL label] [TIMEOUT seconds] [PRECOMPILE headers] [TOGETHER] [JOINED]): one
# GoogleTest executable, each test a ctest; TOGETHER: one ctest for all, which share the recordings that their suites render. So it
# is with sanitizers, too, under which a program takes seconds to start. JOINED: a unity build joins its sources, which therefore
# share no unnamed helper's name. The label is the room unless given.
function(scanknit_test name)
  cmake_parse_arguments(TEST "TOGETHER;JOINED" "LABEL;TIMEOUT" "SOURCES;LIBRARIES;PRECOMPILE" ${ARGN})
  if(NOT TEST_LABEL)
    get_filename_component(TEST_LABEL ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  endif()
  if(SCANKNIT_SANITIZE)
    set(TEST_TIMEOUT 3600)
  elseif(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 600)
  endif()
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE ${TEST_LIBRARIES} scanknit_test_places GTest::gtest_main)
  if(TEST_JOINED AND SCANKNIT_JOIN_TESTS)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON)
  endif()
  scanknit_flags(${name})
  if(TEST_PRECOMPILE)
    target_precompile_headers(${name} PRIVATE <gtest/gtest.h> ${SCANKNIT_PRECOMPILED} ${TEST_PRECOMPILE})
  else()
    target_precompile_headers(${name} REUSE_FROM scanknit_test_headers)
  endif()
  if(TEST_TOGETHER OR SCANKNIT_SANITIZE)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS ${TEST_LABEL} TIMEOUT ${TEST_TIMEOUT})
    return()
  endif()
  # Long enough for a program's list of tests, even while others run.
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${TEST_LABEL} TIMEOUT ${TEST_TIMEOUT})
endfunction()
