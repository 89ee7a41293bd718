#!/usr/bin/env bash
# Builds readers, drivers and the code under them with a sanitizer and runs their tests: run.sh KIND BUILD_DIR [BESIDE]
#   address   clang: addresses, leaks, undefined behaviour; and 10 s of fuzzing of every parser
#   thread    the compiler in use: the threads of the USB drivers, with emulated cameras
# BESIDE is the build under test: with it the program is run as well (project/CMakeLists.txt says what comes from there). Uses
# SCANKNIT_JOBS processors, all unless said. Prints SKIPPED when the compiler is missing.
set -euo pipefail
kind="$1"
build_dir="$2/$kind"
source_dir="$(cd "$(dirname "$0")/../.." && pwd)"
jobs="${SCANKNIT_JOBS:-$(nproc)}"

options=(-DCMAKE_BUILD_TYPE=Debug "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1" -DCMAKE_UNITY_BUILD=ON
  -DSCANKNIT_BUILD_VIEW=ON -DSCANKNIT_BUILD_TESTS=ON)
tests=(test_usb test_view)
program_tests=()  # those that run the program
if command -v umockdev-wrapper >/dev/null; then
  tests+=(test_usb_emulated)
  if [ $# -ge 3 ]; then
    program_tests=(test_usb_commands test_usb_capture)
    options+=("-DBESIDE=$3" -DSCANKNIT_BUILD_APP=ON)
  fi
fi
targets=()
case "$kind" in
  address)  # warnings are for the compiler that we build with
    if ! command -v clang++ >/dev/null || [ ! -e "$(clang++ -print-file-name=libclang_rt.fuzzer-x86_64.a)" ]; then
      echo "SKIPPED: no clang with its run-time libraries (Debian packages clang, libclang-rt-14-dev)"
      exit 0
    fi
    options+=(-DCMAKE_CXX_COMPILER=clang++ -DSCANKNIT_WERROR=OFF -DSCANKNIT_BUILD_FUZZERS=ON
      -DSCANKNIT_SANITIZE=fuzzer-no-link,address,undefined)
    tests+=(test_acquire_record test_acquire_replay)
    targets=(fuzzers)
    ;;
  thread) options+=(-DSCANKNIT_SANITIZE=thread) ;;
esac
if [ ${#program_tests[@]} -eq 0 ]; then options+=(-DSCANKNIT_BUILD_APP=OFF); fi
targets+=("${tests[@]}" "${program_tests[@]}")

mkdir -p "$build_dir"
if ! { cmake -S "$source_dir/tests/sanitizers/project" -B "$build_dir" -G Ninja "${options[@]}" &&
       cmake --build "$build_dir" -j "$jobs" --target "${targets[@]}"; } >"$build_dir/build.log" 2>&1; then
  tail -n 60 "$build_dir/build.log"
  exit 1
fi
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
# clang 14 looks for leaks also where it believes the thread-local data of libraries to be. With this C library it can be wrong, and
# then its own search crashes at the program's end ("Tracer caught signal 11").
export ASAN_OPTIONS="intercept_tls_get_addr=0:${ASAN_OPTIONS:-}"
export TSAN_OPTIONS="halt_on_error=1:second_deadlock_stack=1:suppressions=$source_dir/tests/usb/umockdev/tsan.supp"
# OpenNI2 finds its drivers beside itself, and these are not ours to mend: they leak, are unloaded before the names in
# a report are looked for, and read an attribute that is not there any more when an emulated device goes.
openni2=$(ldconfig -p | awk '/libOpenNI2\.so\.0 / && !found { print $NF; found = 1 }')  # to the end, else ldconfig fails
mkdir -p "$build_dir/without_drivers"
if [ -n "$openni2" ]; then ln -sf "$openni2" "$build_dir/without_drivers/"; fi
export LD_LIBRARY_PATH="$build_dir/without_drivers${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
ctest=(ctest --test-dir "$build_dir/scanknit" --output-on-failure --no-tests=error -j "$jobs")
finding='(ERROR|WARNING): [A-Za-z]+Sanitizer|runtime error:'  # what a sanitizer prints of what it finds
# run "PROGRAM ..." TEST ...: all tests of those programs but the ones that are named. Tests that fail though the sanitizer found
# nothing run again by themselves, up to three times: they wait for a device's clock, which an instrumented program on a busy
# processor can miss; without a sanitizer they must pass at once.
# A program that crashed or hung is not given another run.
run() {
  local programs="$1" left_out failed
  shift
  left_out=$(IFS=:; echo "-$*")
  if GTEST_FILTER="$left_out" "${ctest[@]}" -R "^(${programs// /|})\$" | tee "$build_dir/tests.log"; then return; fi
  failed=$(sed -n 's/^\[  FAILED  \] \([^ ,]*\.[^ ,]*\).*/\1/p' "$build_dir/tests.log" | sort -u | paste -sd :)
  if [ -z "$failed" ] || grep -qE "$finding"'|^\s+[0-9]+ - .* \([^F].*\)$' "$build_dir/tests.log"; then exit 1; fi
  for again in 1 2 3; do
    echo "Again ($again): $failed"
    if GTEST_FILTER="$failed" "${ctest[@]}" --rerun-failed | tee "$build_dir/tests.log"; then return; fi
    if grep -qE "$finding" "$build_dir/tests.log"; then exit 1; fi
  done
  exit 1
}

if [ "$kind" = address ]; then "${ctest[@]}" -L '^fuzz$'; fi
# These measure what an instrumented program cannot give.
left_out=('*LeavesTheProcessorAlone*' '*ArrivesWithoutALoss*' 'SlowConsumer.*')
# The threads have no part in the many ways in which a camera's descriptors may be wrong.
if [ "$kind" = thread ]; then left_out+=('PluggedCamera.WithHostileDescriptors*'); fi
run "${tests[*]}" "${left_out[@]}"

if [ ${#program_tests[@]} -gt 0 ]; then
  # Killed asks for what was written within a second, KeepsEveryPicture for all of them, TellsOfLostPictures must answer before a
  # silent camera is given up. The others render long walks, which takes minutes.
  left_out=('Killed.*' 'RecordCommand.KeepsEveryPicture' 'CaptureView.TellsOfLostPictures*'
    'CaptureStop.*' 'CaptureView.ARefined*' 'RecordCommand.WithoutACalibration*')
  for walk in Ends Colours Bakes Leaves Takes Unplugged PluggedIn Puts WithoutACalibration WhoseScannerFailsWhile; do
    left_out+=("CaptureCommand.$walk*")
  done
  if [ "$kind" = thread ]; then
    # On one processor TBB has no threads, which the sanitizer would take for racing; ours take turns. There a second
    # signal may come when the mesh is written already.
    left_out+=('Interrupted.CaptureStopsAtOnce*')
    taskset -p -c "$(awk '/^Cpus_allowed_list/ { print $2 + 0 }' /proc/self/status)" $$ >/dev/null
  else
    left_out+=('CaptureView.*')
  fi
  run "${program_tests[*]}" "${left_out[@]}"
fi
