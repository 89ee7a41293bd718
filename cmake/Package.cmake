# Debian packages: cpack --config BUILD/CPackConfig.cmake -B FOLDER. One for each component.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME scanknit)
set(CPACK_PACKAGE_VENDOR ScanKnit)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # else it would come before each package's own
set(SCANKNIT_PACKAGE_CONTACT "ScanKnit maintainers <maintainers@scanknit.example>" CACHE STRING
    "Who answers for the packages")
set(CPACK_PACKAGE_CONTACT ${SCANKNIT_PACKAGE_CONTACT})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_BINARY_DIR}/package/finish_tree.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)  # as Debian's own packages: smaller than gzip
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)  # who links with our libraries depends on this very version
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# scanknit_package(COMPONENT NAME package SECTION section SUMMARY ... TEXT ... [DEPENDS ...] [SUGGESTS ...])
set(packaged_components "")
set(packaged_names "")
function(scanknit_package component)
  cmake_parse_arguments(DEB "" "NAME;SECTION;SUMMARY;TEXT;DEPENDS;SUGGESTS" "" ${ARGN})
  string(TOUPPER ${component} key)
  foreach(pair "PACKAGE_NAME;${DEB_NAME}" "PACKAGE_SECTION;${DEB_SECTION}" "PACKAGE_DEPENDS;${DEB_DEPENDS}"
          "PACKAGE_SUGGESTS;${DEB_SUGGESTS}" "DESCRIPTION;${DEB_SUMMARY}\n${DEB_TEXT}")
    list(POP_FRONT pair name)
    set(CPACK_DEBIAN_${key}_${name} "${pair}" PARENT_SCOPE)
  endforeach()
  set(packaged_components ${packaged_components} ${component} PARENT_SCOPE)
  set(packaged_names ${packaged_names} ${DEB_NAME} PARENT_SCOPE)
endfunction()

set(same_version "= ${PROJECT_VERSION}")
scanknit_package(runtime NAME scanknit SECTION graphics SUGGESTS "scanknit-openni2, scanknit-step"
  SUMMARY "coloured meshes from depth cameras"
  TEXT "ScanKnit fuses the frames of a depth camera, live or recorded, with their
poses or tracked, into a signed distance volume and writes a manifold, coloured
mesh of it: GLB, PLY, OBJ, STL or 3MF.
.
This package holds the command scanknit, its libraries, the rules that let
users open their cameras, manual pages, completion for bash, zsh and fish, and
a sample recording.")
scanknit_package(dev NAME libscanknit-dev SECTION libdevel
  DEPENDS "scanknit (${same_version}), libeigen3-dev, libopenvdb-dev, libtbb-dev, libimath-dev"
  SUMMARY "coloured meshes from depth cameras (headers)"
  TEXT "ScanKnit fuses the frames of a depth camera into a signed distance volume and
writes a manifold, coloured mesh of it.
.
This package holds what programs need to use the libraries by CMake's
find_package(ScanKnit) or by pkg-config, and two examples.")
if(TARGET scanknit_openni2)
  scanknit_package(openni2 NAME scanknit-openni2 SECTION graphics DEPENDS "scanknit (${same_version})"
    SUMMARY "coloured meshes from depth cameras (OpenNI2)"
    TEXT "ScanKnit fuses the frames of a depth camera into a signed distance volume and
writes a manifold, coloured mesh of it.
.
This package lets it use cameras that have an OpenNI2 driver.")
endif()
if(TARGET scanknit_step_reader)
  scanknit_package(step NAME scanknit-step SECTION graphics DEPENDS "scanknit (${same_version})"
    SUMMARY "coloured meshes from depth cameras (STEP)"
    TEXT "ScanKnit fuses the frames of a depth camera into a signed distance volume and
writes a manifold, coloured mesh of it.
.
This package lets it compare meshes with the STEP models of CAD programs.")
endif()
if(TARGET scanknit_python)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")  # an extension is made for one minor version
  scanknit_package(python NAME python3-scanknit SECTION python
    DEPENDS "scanknit (${same_version}), python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${next_minor}), python3-numpy"
    SUMMARY "coloured meshes from depth cameras (Python)"
    TEXT "ScanKnit fuses the frames of a depth camera into a signed distance volume and
writes a manifold, coloured mesh of it.
.
This package holds the Python module scanknit: NumPy arrays in and out.")
endif()
set(CPACK_COMPONENTS_ALL ${packaged_components})

# The texts that every package has, and what happens when the first is installed and removed.
set(texts ${PROJECT_BINARY_DIR}/package)
string(TIMESTAMP SCANKNIT_PACKAGE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component name IN ZIP_LISTS packaged_components packaged_names)
  set(SCANKNIT_PACKAGE_NAME ${name})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/package/changelog.in ${texts}/${name}/changelog @ONLY)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/package/copyright ${texts}/${name}/changelog
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endforeach()
set(scripts ${PROJECT_SOURCE_DIR}/cmake/package)
# What they are made of, as SPDX: docs/packages.md. Made again when the build is configured.
find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND)
  set(lock ${PROJECT_SOURCE_DIR}/view/page/package-lock.json)
  get_directory_property(release_date DIRECTORY core DEFINITION SCANKNIT_RELEASE_DATE)
  execute_process(COMMAND ${Python3_EXECUTABLE} -B ${scripts}/sbom.py ${PROJECT_VERSION} ${release_date} ${lock}
                          ${texts}/scanknit.spdx.json COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${texts}/scanknit.spdx.json DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/scanknit COMPONENT runtime)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${scripts}/sbom.py ${lock})
endif()
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${scripts}/postinst ${scripts}/postrm ${scripts}/triggers)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${scripts}/python/prerm)
configure_file(${scripts}/finish_tree.cmake ${texts}/finish_tree.cmake COPYONLY)

include(CPack)
