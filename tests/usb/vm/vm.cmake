# The same tests, and some that need a real kernel, in a virtual machine: real USB core, usbfs, udev, uvcvideo.
add_library(scanknit_vhci_bus STATIC vhci/emulated_bus.cpp)
target_link_libraries(scanknit_vhci_bus PUBLIC scanknit_vcam)
scanknit_flags(scanknit_vhci_bus)

add_executable(test_usb_vm $<TARGET_OBJECTS:emulated_camera_tests> vm/test_system.cpp ../app/program.cpp)
target_link_libraries(test_usb_vm PRIVATE scanknit_vhci_bus nlohmann_json::nlohmann_json GTest::gtest_main)
target_compile_definitions(test_usb_vm PRIVATE SCANKNIT_PROGRAM="$<TARGET_FILE:scanknit>")
scanknit_flags(test_usb_vm)
#add_dependencies(test_usb_vm scanknit)

# Without the one that measures time: the machine is emulated in software.
add_test(NAME UsbVm
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/vm/run.sh ${CMAKE_CURRENT_BINARY_DIR}/vm
    $<TARGET_FILE:test_usb_vm> --gtest_filter=-*LeavesTheProcessorAlone)
set_tests_properties(UsbVm PROPERTIES LABELS usb SKIP_RETURN_CODE 77 TIMEOUT 320 RUN_SERIAL TRUE)
