# Installs into an empty prefix; compiles each header that is there; configures, builds and runs the examples against it; the
# same by pkg-config.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}\n${output}")
  endif()
endfunction()

set(prefix ${WORK_DIR}/prefix)
file(REMOVE_RECURSE ${prefix} ${WORK_DIR}/build ${WORK_DIR}/headers)
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

file(STRINGS ${HEADERS_FILE} listed)
file(GLOB_RECURSE installed RELATIVE ${prefix}/include/scanknit ${prefix}/include/*)
list(SORT listed)
list(SORT installed)
if(NOT installed STREQUAL listed)
  message(FATAL_ERROR "installed: ${installed}\nexpected: ${listed}")
endif()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/headers -B ${WORK_DIR}/headers -DCMAKE_PREFIX_PATH=${prefix}
    -DHEADERS_FILE=${HEADERS_FILE})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/headers --parallel 2)

run(${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/mesh_a_wall ${WORK_DIR}/build/wall.glb)
run(${prefix}/bin/scanknit --version)
run(${prefix}/bin/scanknit info ${WORK_DIR}/build/wall.glb)
# By the module that reads volumes.
file(WRITE ${WORK_DIR}/cube.nrrd
     "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n")
run(${prefix}/bin/scanknit info ${WORK_DIR}/cube.nrrd)
run(${prefix}/bin/scanknit info ${prefix}/share/scanknit/samples/turntable.mcap)

# The example of a whole scan writes the program's files, but no report.
set(turning ${WORK_DIR}/build/turning)
run(${prefix}/bin/scanknit synth tower --turntable --frames 24 --width 320 --height 240 --noise --seed 1 -o ${turning} --quiet)
run(${prefix}/bin/scanknit run ${turning} --preset turntable -o ${turning}/by_program --quiet)
run(${WORK_DIR}/build/scan_a_turntable ${turning} ${turning}/by_example)
foreach(file model.glb model.ply preview.png error.png coverage.png trajectory.txt)
  run(${CMAKE_COMMAND} -E compare_files ${turning}/by_program/${file} ${turning}/by_example/${file})
endforeach()

set(ENV{PKG_CONFIG_PATH} ${prefix}/${LIBDIR}/pkgconfig)
execute_process(COMMAND pkg-config --cflags --libs scanknit OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
                COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
set(program ${WORK_DIR}/build/by_pkg_config)
if(SANITIZE)
  list(APPEND flags -fsanitize=${SANITIZE})
endif()
run(${COMPILER} -std=c++20 ${EXAMPLE_DIR}/mesh_a_wall.cpp -o ${program} ${flags} -Wl,-rpath,${prefix}/${LIBDIR})
run(${program} ${WORK_DIR}/build/same_wall.glb)
run(${CMAKE_COMMAND} -E compare_files ${WORK_DIR}/build/wall.glb ${WORK_DIR}/build/same_wall.glb)
