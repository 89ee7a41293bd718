// What the program's exit code says. The table of docs/cli.md.
#pragma once

#include "core/result.h"

namespace scanknit {

inline constexpr int kExitOk = 0;
inline constexpr int kExitInterrupted = 130;  ///< 128 + SIGINT, as shells count

/// Each ErrorCode has one exit code. They never change: scripts depend on them.
[[nodiscard]] constexpr int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInternal: return 1;
    case ErrorCode::kUsage: return 2;
    case ErrorCode::kConfig: return 3;
    case ErrorCode::kInput: return 4;
    case ErrorCode::kDevice: return 5;
    case ErrorCode::kTooLittle: return 6;
    case ErrorCode::kMesh: return 7;
    case ErrorCode::kOutput: return 8;
    case ErrorCode::kBudget: return 9;
  }
  return 1;
}

/// For the end of --help.
inline constexpr const char* kExitCodesHelp =
    "Exit codes: 0 ok, 1 internal error, 2 usage, 3 configuration, 4 input unreadable or no usable frame, 5 device,\n"
    "6 tracking lost or too little data, 7 empty or invalid mesh, 8 output not writable, 9 memory budget, 130 "
    "interrupted\n"
    "(what there was has been written).";

}  // namespace scanknit
