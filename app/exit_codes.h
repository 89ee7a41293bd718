// The program's exit codes, as in docs/cli.md.
#pragma once

#include <array>
#include <string>
#include <string_view>

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

/// The error that another process of this program reported by its exit code; kInternal for all other codes.
[[nodiscard]] constexpr ErrorCode error_code_of(int exit_code) {
  for (const ErrorCode code : {ErrorCode::kUsage, ErrorCode::kConfig, ErrorCode::kInput, ErrorCode::kDevice,
                               ErrorCode::kTooLittle, ErrorCode::kMesh, ErrorCode::kOutput, ErrorCode::kBudget}) {
    if (exit_code_of(code) == exit_code) return code;
  }
  return ErrorCode::kInternal;
}

struct ExitCode {
  int code;
  std::string_view text;
};

/// For --help and the manual pages.
inline constexpr std::array<ExitCode, 11> kExitCodes = {{
    {kExitOk, "ok"},
    {exit_code_of(ErrorCode::kInternal), "internal error"},
    {exit_code_of(ErrorCode::kUsage), "usage"},
    {exit_code_of(ErrorCode::kConfig), "configuration"},
    {exit_code_of(ErrorCode::kInput), "input unreadable or no usable frame"},
    {exit_code_of(ErrorCode::kDevice), "device"},
    {exit_code_of(ErrorCode::kTooLittle), "tracking lost or too little data"},
    {exit_code_of(ErrorCode::kMesh), "empty or invalid mesh (or beyond its tolerance)"},
    {exit_code_of(ErrorCode::kOutput), "output not writable"},
    {exit_code_of(ErrorCode::kBudget), "memory budget"},
    {kExitInterrupted, "interrupted (the result so far was written)"},
}};

/// For the end of --help: "Exit codes: 0 ok, 1 internal error ...", in two lines.
[[nodiscard]] inline std::string exit_codes_help() {
  std::string text = "Exit codes:";
  for (const ExitCode& exit : kExitCodes) {
    const bool is_second_line = exit.code == exit_code_of(ErrorCode::kTooLittle);
    text += (is_second_line ? "\n" : " ") + std::to_string(exit.code) + " " + std::string(exit.text);
    text += exit.code == kExitInterrupted ? "." : ",";
  }
  return text;
}

}  // namespace scanknit
