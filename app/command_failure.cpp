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
  return exit_code_of(error.code);
}

ConfigSources with_run_defaults(ConfigSources sources) {
  sources.presets.insert(sources.presets.begin(), "default");
  return sources;
}

}  // namespace scanknit
