# The same tests, and some that need a real kernel, in a virtual machine: real USB core, usbfs, udev, uvcvideo.
add_library(scanknit_vhci_bus STATIC vhci/emulated_bus.cpp)
target_link_libraries(scanknit_vhci_bus PUBLIC scanknit_vcam)
scanknit_flags(scanknit_vhci_bus)

add_executable(test_usb_vm $<TARGET_OBJECTS:emulated_camera_tests> vm/test_system.cpp)
target_link_libraries(test_usb_vm PRIVATE
  scanknit_vhci_bus scanknit_test_program ${emulated_camera_libraries} nlohmann_json::nlohmann_json GTest::gtest_main)
scanknit_flags(test_usb_vm)
add_dependencies(test_usb_vm scanknit)

# The machine is emulated in software: without what needs or measures speed (libfreenect takes long to start and stop
# there), and without some of what differs from its neighbours in bytes only, of which umockdev's run sees enough.
set(left_out
  *LeavesTheProcessorAlone *At90 *MiddlingPayloads *SlowConsumer* EmulatedKinect.StreamsDepth* EmulatedKinect.Never*
  *InPieces */ShortPayload */LongPayload */RepeatedPayload */Reordered *Ms/Unplug*/1 *Ms/Unplug*/3 *Ms/Unplug*/4
  *Vendor/Infrared* FaultyKinect.ThatAnswersNothing* OpenedCamera.ThatAnswersNothing* *LastingFaultOfColour*/Silence
  *IsochronousMjpeg FaultyKinect.WhoseColour*)
string(JOIN : left_out ${left_out})
add_test(NAME UsbVm
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/vm/run.sh ${CMAKE_CURRENT_BINARY_DIR}/vm
    $<TARGET_FILE:test_usb_vm> --gtest_color=no --gtest_filter=-${left_out})
set_tests_properties(UsbVm PROPERTIES LABELS usb SKIP_RETURN_CODE 77 TIMEOUT 900 RUN_SERIAL TRUE
  ENVIRONMENT SCANKNIT_VM_MACHINES=2)
