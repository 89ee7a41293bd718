// The commands and options of the program as its --help lists them: CLI11's own words, to compare ours with.
#pragma once

#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace scanknit {

/// "config print" as arguments.
inline std::vector<std::string> arguments_of(const std::string& path) {
  std::istringstream words(path);
  std::vector<std::string> arguments;
  for (std::string word; words >> word;) arguments.push_back(word);
  return arguments;
}

inline const std::string& help_of(const std::string& path) {
  static std::map<std::string, std::string> known;
  const auto [help, is_new] = known.try_emplace(path);
  if (is_new) {
    std::vector<std::string> arguments = arguments_of(path);
    arguments.emplace_back("--help");
    help->second = scanknit_command(arguments).out;
  }
  return help->second;
}

/// The commands below `path`: "run", "capture" ... of "", "print" ... of "config".
inline std::vector<std::string> commands_of(const std::string& path) {
  const std::regex line_of_command(R"(^  ([a-z][a-z-]*)( .*)?$)");
  std::istringstream help(help_of(path));
  std::vector<std::string> commands;
  bool is_list = false;
  for (std::string line; std::getline(help, line);) {
    if (!line.starts_with(' ')) is_list = line.starts_with("Subcommands:");
    std::smatch match;
    if (is_list && std::regex_match(line, match, line_of_command)) commands.push_back(match[1]);
  }
  return commands;
}

/// "", every command, and every command of a command: "config print".
inline std::vector<std::string> all_paths() {
  std::vector<std::string> paths = {""};
  for (const std::string& command : commands_of("")) {
    paths.push_back(command);
    for (const std::string& below : commands_of(command)) paths.push_back(command + " " + below);
  }
  return paths;
}

/// "--output", "-o" ... of the command.
inline std::vector<std::string> options_of(const std::string& path) {
  const std::regex names(R"(^  (-[a-zA-Z])?,?(--[a-z0-9-]+)?.*$)");
  std::istringstream help(help_of(path));
  std::vector<std::string> options;
  for (std::string line; std::getline(help, line);) {
    std::smatch match;
    if (!line.starts_with("  -") || !std::regex_match(line, match, names)) continue;
    for (const std::size_t part : {1u, 2u}) {
      if (match[part].length() > 0) options.push_back(match[part]);
    }
  }
  return options;
}

}  // namespace scanknit
