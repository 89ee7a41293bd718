// The command line.
#pragma once

namespace scanknit {

/// Parses, runs the command, returns the exit code of app/exit_codes.h. Throws nothing.
[[nodiscard]] int run_cli(int argc, const char* const* argv);

}  // namespace scanknit
