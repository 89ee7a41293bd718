#include <cerrno>
#include <cstdio>
#include <cstring>

#include "app/commands.h"
#include "app/exit_codes.h"

namespace scanknit {

int fail(const Error& error, const CommonArguments& common) {
  Console console(common.verbosity);
  // Errors of the configuration already are lines of "file:line:column: error: message", as editors expect them.
  if (error.code == ErrorCode::kConfig && error.where.empty()) {
    console.plain(error.message);
  } else {
    console.error(error.text());
  }
  if (error.code == ErrorCode::kDevice)
    console.info(
        "scanknit doctor finds what keeps a scanner from working; --force takes it from a program that uses it");
  return exit_code_of(error.code);
}

int print_result(std::string_view text, const CommonArguments& common) {
  const bool is_written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (is_written) return kExitOk;
  return fail({ErrorCode::kOutput, std::string("the result cannot be written: ") + std::strerror(errno), "stdout"},
              common);
}

}  // namespace scanknit
