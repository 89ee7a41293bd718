#!/bin/sh
# Runs a test program in umockdev's view of the system: run.sh PROGRAM ARGUMENTS
# The preloaded library comes before the address sanitizer's, which must not mind.
export ASAN_OPTIONS="verify_asan_link_order=0:${ASAN_OPTIONS:-}"
export LSAN_OPTIONS="suppressions=$(dirname "$0")/lsan.supp:print_suppressions=0:${LSAN_OPTIONS:-}"
export TSAN_OPTIONS="suppressions=$(dirname "$0")/tsan.supp:${TSAN_OPTIONS:-}"
exec umockdev-wrapper "$@"
