# find_package(ScanKnit) for other projects: libraries, headers, package configuration.
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY SCANKNIT_ROOMS)
install(TARGETS ${rooms} EXPORT ScanKnitTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(room core acquire fusion extract finish export)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room}
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scanknit FILES_MATCHING PATTERN "*.h")
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/generated/core/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scanknit/core)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/scanknit/configs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ScanKnit)
install(EXPORT ScanKnitTargets NAMESPACE ScanKnit:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/ScanKnitConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/ScanKnitConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ScanKnitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ScanKnitConfig.cmake ${PROJECT_BINARY_DIR}/ScanKnitConfigVersion.cmake
        DESTINATION ${package_dir})
