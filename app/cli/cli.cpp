#include "app/cli/cli.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
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

int run_chosen(CommandLine& line) {
  line.common.verbosity = line.is_quiet     ? Verbosity::kQuiet
                          : line.is_verbose ? Verbosity::kVerbose
                                            : Verbosity::kNormal;
  try {
    return line.command();
  } catch (const std::bad_alloc&) {
    return fail({ErrorCode::kBudget, "out of memory"}, line.common);
  } catch (const std::exception& exception) {
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
  return run_chosen(line);
}

}  // namespace scanknit
