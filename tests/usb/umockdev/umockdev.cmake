# An unmodified libusb under umockdev.
pkg_check_modules(umockdev IMPORTED_TARGET umockdev-1.0)
find_program(UMOCKDEV_WRAPPER umockdev-wrapper)
if(NOT umockdev_FOUND OR NOT UMOCKDEV_WRAPPER)
  add_test(NAME EmulatedCamera.All COMMAND ${CMAKE_COMMAND} -E echo
    "SKIPPED: umockdev is not installed (Debian packages umockdev, libumockdev-dev)")
  set_tests_properties(EmulatedCamera.All PROPERTIES SKIP_REGULAR_EXPRESSION SKIPPED LABELS usb)
  return()
endif()

add_library(scanknit_umockdev_bus STATIC umockdev/emulated_bus.cpp)
target_link_libraries(scanknit_umockdev_bus PUBLIC scanknit_vcam PkgConfig::umockdev util)
scanknit_flags(scanknit_umockdev_bus)

# Both the list of tests and the tests themselves are run through run.sh.
function(scanknit_emulated_test name)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${CMAKE_CURRENT_SOURCE_DIR}/umockdev/run.sh)
  scanknit_test(${name} ${ARGN})
endfunction()

scanknit_emulated_test(test_usb_emulated
  SOURCES $<TARGET_OBJECTS:emulated_camera_tests> umockdev/test_hostile.cpp LIBRARIES scanknit_umockdev_bus ${emulated_camera_libraries})
scanknit_emulated_test(test_usb_soak SOURCES umockdev/test_soak.cpp LIBRARIES scanknit_umockdev_bus TIMEOUT 900)
add_executable(bench_acquire umockdev/bench_acquire.cpp)
target_link_libraries(bench_acquire PRIVATE scanknit_umockdev_bus)
scanknit_flags(bench_acquire)
if(SCANKNIT_BUILD_APP)
  scanknit_emulated_test(test_usb_commands LABEL usb_program
    SOURCES emulated/test_commands.cpp emulated/test_killed.cpp
    LIBRARIES scanknit_umockdev_bus scanknit_test_program ScanKnit::export nlohmann_json::nlohmann_json)
  set(slowness 1)
  if(SCANKNIT_SANITIZE)
    set(slowness 4)
  endif()
  target_compile_definitions(test_usb_commands PRIVATE SCANKNIT_SLOWNESS=${slowness})
  add_dependencies(test_usb_commands scanknit)
  scanknit_emulated_test(test_usb_capture LABEL usb_program
    SOURCES emulated/test_capture.cpp emulated/test_capture_pairs.cpp emulated/test_capture_stop.cpp emulated/test_capture_view.cpp emulated/desk_view.cpp
    LIBRARIES scanknit_app_cli scanknit_umockdev_bus scanknit_test_program scanknit_page_client ScanKnit::export ScanKnit::synth)
  add_dependencies(test_usb_capture scanknit_commands scanknit_stereo_opencv)
endif()
