# What is installed, by component: runtime (the program and the rooms), dev (for find_package and pkg-config), openni2, step
# and python. A component is a Debian package: cmake/Package.cmake.
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY SCANKNIT_ROOMS)
install(TARGETS ${rooms} EXPORT ScanKnitTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
get_property(headers GLOBAL PROPERTY SCANKNIT_HEADERS)
foreach(header IN LISTS headers)
  set(path ${PROJECT_SOURCE_DIR}/${header})
  if(header STREQUAL core/version.h)
    set(path ${PROJECT_BINARY_DIR}/generated/${header})
  endif()
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${path} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scanknit/${folder} COMPONENT dev)
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/scanknit/configs COMPONENT runtime)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/cpp
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libscanknit-dev/examples COMPONENT dev)
if(SCANKNIT_BUILD_APP)
  # A recording to begin with: rendered when it is first installed, by the program that comes with it.
  install(CODE "set(scanknit \"$<TARGET_FILE:scanknit>\")
set(sample \"${PROJECT_BINARY_DIR}/sample/turntable.mcap\")
set(destination \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/scanknit/samples\")" COMPONENT runtime)
  install(SCRIPT ${PROJECT_SOURCE_DIR}/cmake/install_sample.cmake COMPONENT runtime)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ScanKnit)
install(EXPORT ScanKnitTargets NAMESPACE ScanKnit:: DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/ScanKnitConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/ScanKnitConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ScanKnitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ScanKnitConfig.cmake ${PROJECT_BINARY_DIR}/ScanKnitConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT dev)

# The file knows where it lies, so that the tree may be moved.
file(RELATIVE_PATH SCANKNIT_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${PROJECT_SOURCE_DIR}/cmake/scanknit.pc.in ${PROJECT_BINARY_DIR}/scanknit.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/scanknit.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
