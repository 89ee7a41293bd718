#include "app/cli/command_tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

namespace scanknit {
namespace {

/// CLI11's texts for the checks of an option, which it writes after the name of the value.
std::vector<std::string> limits_of(CLI::Option& option) {
  std::vector<std::string> limits;
  try {
    for (int i = 0;; ++i) {
      const std::string text = option.get_validator(i)->get_description();
      if (!text.empty()) limits.push_back(text);
    }
  } catch (const CLI::OptionNotFound&) {  // CLI11 does not give the number of checks
  }
  return limits;
}

ValueKind kind_of(std::string_view value) {
  if (value.empty()) return ValueKind::kFlag;
  if (value == "DIR") return ValueKind::kFolder;
  for (const std::string_view file : {"FILE", "OUT", "RECORDING", "VOLUME", "MESH", "SCAN", "SCENE"}) {
    if (value.starts_with(file)) return ValueKind::kFile;
  }
  return ValueKind::kOther;
}

OptionDescription describe_option(CLI::Option& option, const CommandLine& line) {
  OptionDescription described;
  for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
  if (option.get_items_expected_max() > 0) {
    const std::vector<std::string> limits = limits_of(option);
    described.value = option.get_type_name();
    for (const std::string& limit : limits) {
      described.value.resize(described.value.size() - std::min(described.value.size(), limit.size() + 1));  // ":limit"
    }
    described.limits = fmt::format("{}", fmt::join(limits, ", "));
  }
  described.text = option.get_description();
  described.group = option.get_group();
  if (const auto words = line.words.find(&option); words != line.words.end()) described.words = words->second;
  described.kind = kind_of(described.value);
  described.is_required = option.get_required();
  described.is_repeatable = option.get_items_expected_max() > 1;
  return described;
}

}  // namespace

CommandDescription describe_command(CLI::App& app, const CommandLine& line) {
  CommandDescription described{app.get_name(), app.get_description(), {}, {}, {}};
  for (CLI::Option* option : app.get_options([](const CLI::Option* given) { return !given->get_group().empty(); })) {
    auto& place = option->get_positional() ? described.arguments : described.options;
    place.push_back(describe_option(*option, line));
  }
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    described.commands.push_back(describe_command(*command, line));
  }
  return described;
}

}  // namespace scanknit
