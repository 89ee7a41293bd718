#!/usr/bin/env bash
# Builds readers, drivers and the code under them with a sanitizer and runs their tests: run.sh KIND BUILD_DIR
#   address   clang: addresses, leaks, undefined behaviour; and 20 s of fuzzing of every parser
#   thread    the compiler in use: the threads of the USB drivers, with emulated cameras
# Prints SKIPPED when the compiler is missing.
set -euo pipefail
kind="$1"
build_dir="$2/$kind"
source_dir="$(cd "$(dirname "$0")/../.." && pwd)"

options=(-DCMAKE_BUILD_TYPE=Debug "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1" -DSCANKNIT_BUILD_APP=OFF -DSCANKNIT_BUILD_VIEW=ON -DSCANKNIT_BUILD_TESTS=ON)
targets=(test_usb test_view)
if command -v umockdev-wrapper >/dev/null; then targets+=(test_usb_emulated); fi
case "$kind" in
  address)  # warnings are for the compiler that we build with
    if ! command -v clang++ >/dev/null || [ ! -e "$(clang++ -print-file-name=libclang_rt.fuzzer-x86_64.a)" ]; then
      echo "SKIPPED: no clang with its run-time libraries (Debian packages clang, libclang-rt-14-dev)"
      exit 0
    fi
    options+=(-DCMAKE_CXX_COMPILER=clang++ -DSCANKNIT_WERROR=OFF -DSCANKNIT_BUILD_FUZZERS=ON
      -DSCANKNIT_SANITIZE=fuzzer-no-link,address,undefined)
    targets+=(test_acquire_record test_acquire_replay fuzzers)
    ;;
  thread) options+=(-DSCANKNIT_SANITIZE=thread) ;;
esac

mkdir -p "$build_dir"
if ! { cmake -S "$source_dir" -B "$build_dir" -G Ninja "${options[@]}" &&
       cmake --build "$build_dir" --target "${targets[@]}"; } >"$build_dir/build.log" 2>&1; then
  tail -n 60 "$build_dir/build.log"
  exit 1
fi
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS="halt_on_error=1:second_deadlock_stack=1:suppressions=$source_dir/tests/usb/umockdev/tsan.supp"
too_slow='LeavesTheProcessorAlone|ArrivesWithoutALoss|SlowConsumer'  # they measure what an instrumented program cannot give
ctest --test-dir "$build_dir" --output-on-failure --no-tests=error -j "$(nproc)" -L '^(acquire|usb|view|fuzz)$' -E "$too_slow"
