#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "app/cli/completion.h"
#include "core/version.h"

namespace scanknit {
namespace {

std::string fish_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + "'";
}

/// How fish completes the value of an option, or an argument.
std::string completed_by(const OptionDescription& option) {
  std::string text;
  if (option.kind == ValueKind::kFile) text += " -F";
  if (option.kind == ValueKind::kFolder) text += " -a '(__fish_complete_directories)'";
  if (!option.words.empty()) text += " -a " + fish_quoted(fmt::format("{}", fmt::join(option.words, " ")));
  return text;
}

/// `condition`: fish's test for the command's place in the line.
void add_command(const CommandDescription& command, const std::string& condition, std::string& script) {
  const std::string begin = "complete -c scanknit" + (condition.empty() ? "" : " -n " + fish_quoted(condition));
  for (const OptionDescription& option : command.options) {
    script += begin;
    for (const std::string& name : option.names) {
      script += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    if (option.kind != ValueKind::kFlag) script += " -r" + completed_by(option);
    script += " -d " + fish_quoted(option.text) + "\n";
  }
  if (!command.arguments.empty()) script += begin + completed_by(command.arguments.front()) + "\n";

  std::vector<std::string> names;
  for (const CommandDescription& below : command.commands) names.push_back(below.name);
  for (const CommandDescription& below : command.commands) {
    const std::string chosen = "__fish_seen_subcommand_from " + below.name;
    const std::string open = fmt::format("not __fish_seen_subcommand_from {}", fmt::join(names, " "));
    const std::string join = condition.empty() ? "" : condition + "; and ";
    script += fmt::format("complete -c scanknit -n {} -a {} -d {}\n", fish_quoted(join + open), below.name,
                          fish_quoted(below.text));
    add_command(below, join + chosen, script);
  }
}

}  // namespace

std::string fish_completion(const CommandDescription& program) {
  std::string script = fmt::format(
      "# Completion of scanknit {}, written by `scanknit completion fish`.\ncomplete -c scanknit -f\n", kVersion);
  add_command(program, "", script);
  return script;
}

}  // namespace scanknit
