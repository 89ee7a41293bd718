#include "app/cli/cli.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "app/cli/command_line.h"
#include "app/config/suggestion.h"
#include "app/exit_codes.h"
#include "core/version.h"

namespace scanknit {
namespace {

/// The hint that follows CLI11's own message.
std::string hint_for(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2) return "";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return fmt::format("\nSee scanknit {} --help", argv[1]);
    names.push_back(command->get_name());
  }
  const auto near = nearest_word(argv[1], names);
  return near ? fmt::format("\nDid you mean scanknit {}?", *near) : "\nSee scanknit --help";
}

/// What the system did not give to the command of this name.
Error out_of_memory(const std::string& command) {
  return {ErrorCode::kBudget,
          "out of memory; end other programs, or let it do less: larger voxels (fusion.voxel_size), smaller pictures, "
          "fewer --threads",
          command};
}

Error out_of_threads(const std::string& command) {
  return {ErrorCode::kBudget, "the system has no thread left; end other programs, or raise ulimit -u", command};
}

/// TBB has no type for it.
bool is_lack_of_threads(const std::exception& fault) {
  const auto* of_system = dynamic_cast<const std::system_error*>(&fault);
  if (of_system != nullptr) return of_system->code() == std::errc::resource_unavailable_try_again;
  return std::string_view(fault.what()).starts_with("pthread_create has failed");
}

/// `name`: the command's, for messages.
int run_chosen(CommandLine& line, const std::string& name) {
  line.common.verbosity = line.is_quiet     ? Verbosity::kQuiet
                          : line.is_verbose ? Verbosity::kVerbose
                                            : Verbosity::kNormal;
  try {
    return line.command();
  } catch (const std::bad_alloc&) {
    return fail(out_of_memory(name), line.common);
  } catch (const std::exception& exception) {
    if (is_lack_of_threads(exception)) return fail(out_of_threads(name), line.common);
    return fail({ErrorCode::kInternal, fmt::format("internal error: {}", exception.what())}, line.common);
  }
}

}  // namespace

int run_cli(int argc, const char* const* argv) {
  CommandLine line;
  CLI::App app("ScanKnit: from depth frames to a coloured, correct mesh", "scanknit");
  app.set_version_flag("-V,--version", std::string("scanknit ") + kVersion);
  app.set_help_all_flag("--help-all", "Help of every command");
  app.footer(exit_codes_help());
  app.require_subcommand(0, 1);
  add_commands(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    fmt::print(stderr, "error: {}{}\n", error.what(), hint_for(app, argc, argv));
    return exit_code_of(ErrorCode::kUsage);
  }
  if (!line.command) {
    fmt::print("{}", app.help());
    return kExitOk;
  }
  return run_chosen(line, app.get_subcommands().front()->get_name());
}

}  // namespace scanknit
