// Describes the command line in plain values, taken from CLI11's options, for completion and manual pages.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "app/cli/command_line.h"

namespace scanknit {

enum class ValueKind {
  kFlag,    ///< no value
  kFile,    ///< a file, or a folder in its place
  kFolder,  ///< a folder
  kOther,   ///< a number, a word ...
};

struct OptionDescription {
  std::vector<std::string> names;  ///< "-o", "--output"; none: a positional argument
  std::string value;               ///< "FILE"; empty for a flag
  std::string limits;              ///< "INT in [1 - 1024]"; may be empty
  std::string text, group;
  std::vector<std::string> words;  ///< possible values; a word that ends in '=' is the beginning of one; may be empty
  ValueKind kind = ValueKind::kFlag;
  bool is_required = false, is_repeatable = false;
};

struct CommandDescription {
  std::string name, text;
  std::vector<OptionDescription> arguments;  ///< positional, in order
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> commands;
};

/// Describes `app` and its subcommands, without hidden options.
[[nodiscard]] CommandDescription describe_command(CLI::App& app, const CommandLine& line);

}  // namespace scanknit
