// `completion` and `man`: scripts for shells, and manual pages.
#include <string>

#include "app/cli/completion.h"
#include "app/cli/man_page.h"
#include "app/exit_codes.h"
#include "core/files/atomic_file.h"

namespace scanknit {

int completion_command(const CommandDescription& program, const CompletionArguments& arguments) {
  switch (arguments.shell) {
    case Shell::kBash: return print_result(bash_completion(program), {});
    case Shell::kZsh: return print_result(zsh_completion(program), {});
    case Shell::kFish: return print_result(fish_completion(program), {});
  }
  return exit_code_of(ErrorCode::kInternal);
}

int man_command(const CommandDescription& program, const ManArguments& arguments) {
  for (const ManPage& page : man_pages(program)) {
    if (const auto written = write_file_atomically(arguments.output / page.file, page.text); !written) {
      return fail(written.error(), {});
    }
  }
  return kExitOk;
}

}  // namespace scanknit
