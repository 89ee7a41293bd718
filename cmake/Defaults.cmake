# Language, build type, output folders, compiler launcher: what every target shares.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
# SCANKNIT_CHECK stays on in every build type; -O2 keeps compile times in hand.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

# A unity build (-DCMAKE_UNITY_BUILD=ON) joins this many sources of a target. Their unnamed helpers have different names.
set(CMAKE_UNITY_BUILD_BATCH_SIZE 5 CACHE STRING "Sources that a unity build joins")

include(GNUInstallDirs)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR};$ORIGIN")

# Precompiled headers and ccache agree only when ccache is told to trust the compiler about them. Paths below this checkout
# are compared as relative ones, so that another checkout of the same sources finds everything in the cache.
find_program(SCANKNIT_CCACHE ccache)
if(SCANKNIT_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}
      CCACHE_NOHASHDIR=1 ${SCANKNIT_CCACHE})
endif()
