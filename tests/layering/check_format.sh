#!/usr/bin/env bash
# Every source file is as clang-format 14 leaves it: check_format.sh SOURCE_DIR. Exit code 77: cannot be checked here.
set -euo pipefail
cd "$1"
if ! clang-format --version 2>/dev/null | grep -q ' 14\.'; then
  echo "SKIPPED: clang-format 14 is not installed (Debian package clang-format)"
  exit 77
fi
find core acquire measure synth fusion extract finish export scan view app bench examples python tests -name '*.h' -o -name '*.cpp' | xargs clang-format --dry-run -Werror
