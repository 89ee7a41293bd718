// The command line described in plain values, read off the options themselves: completion and manual pages come from
// it.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "app/cli/command_line.h"

namespace scanknit {

enum class ValueKind {
  kFlag,    ///< no value
  kFile,    ///< a file, or a folder that stands for one
  kFolder,  ///< a folder
  kOther,   ///< a number, a word ...
};

struct OptionDescription {
  std::vector<std::string> names;  ///< "-o", "--output"; none: an argument known by its place
  std::string value;               ///< "FILE"; empty for a flag
  std::string limits;              ///< "INT in [1 - 1024]"; may be empty
  std::string text, group;
  std::vector<std::string> words;  ///< what the value may be, or begin with where a word ends in '='; may be empty
  ValueKind kind = ValueKind::kFlag;
  bool is_required = false, is_repeatable = false;
};

struct CommandDescription {
  std::string name, text;
  std::vector<OptionDescription> arguments;  ///< known by their place, in order
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> commands;
};

/// `app` and the commands below it. Hidden options are left out.
[[nodiscard]] CommandDescription describe_command(CLI::App& app, const CommandLine& line);

}  // namespace scanknit
