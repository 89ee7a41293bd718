# scanknit_flags(target): warnings, sanitizers, and arithmetic that gives the same bits on every machine.
function(scanknit_flags target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wconversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast
    -ffp-contract=off -fno-semantic-interposition
    $<$<BOOL:${SCANKNIT_WERROR}>:-Werror>)
  if(SCANKNIT_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${SCANKNIT_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${SCANKNIT_SANITIZE})
    # Asio has fences, which this sanitizer does not see; what is behind them it sees by the locks beside them.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
  endif()
endfunction()

# scanknit_room(name SOURCES ... PUBLIC ... PRIVATE ... [PRECOMPILE header]): the library ScanKnit::name, whose headers
# are included as "name/header.h".
function(scanknit_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;PUBLIC;PRIVATE;PRECOMPILE" ${ARGN})
  set(target scanknit_${name})
  if(SCANKNIT_SANITIZE_BESIDE AND NOT name MATCHES "^(core|acquire|scan|view)$")
    add_library(${target} SHARED IMPORTED GLOBAL)
    add_library(ScanKnit::${name} ALIAS ${target})
    set_target_properties(${target} PROPERTIES IMPORTED_LOCATION ${SCANKNIT_SANITIZE_BESIDE}/lib/libscanknit_${name}.so)
    target_link_libraries(${target} INTERFACE ${ROOM_PUBLIC})
    return()
  endif()
  add_library(${target} ${ROOM_SOURCES})
  add_library(ScanKnit::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/scanknit>)
  target_link_libraries(${target} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  target_precompile_headers(${target} PRIVATE ${ROOM_PRECOMPILE})
  scanknit_flags(${target})
  set_property(GLOBAL APPEND PROPERTY SCANKNIT_ROOMS ${target})
endfunction()

# scanknit_module(name SOURCES ... LIBRARIES ... [COMPONENT component]): libscanknit_name.so, which core/module.h opens when
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

# scanknit_test(name SOURCES ... LIBRARIES ... [LABEL label] [TIMEOUT seconds]): one GoogleTest executable, each test a
# ctest. The label is the room unless given.
function(scanknit_test name)
  cmake_parse_arguments(TEST "" "LABEL;TIMEOUT" "SOURCES;LIBRARIES" ${ARGN})
  if(NOT TEST_LABEL)
    get_filename_component(TEST_LABEL ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  endif()
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 600)
  endif()
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE ${TEST_LIBRARIES} scanknit_test_places GTest::gtest_main)
  scanknit_flags(${name})
  # Under sanitizers a program is slow to start: long enough for its list of tests, even while others run.
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${TEST_LABEL} TIMEOUT ${TEST_TIMEOUT})
endfunction()
