#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "app/cli/completion.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr const char* kHead = R"zsh(#compdef scanknit
# Completion of scanknit {}, written by `scanknit completion zsh`.

_scanknit_words_or_files() {{
  compadd -- "$@"
  _files
}}

_scanknit_keys() {{
  compadd -S '' -- "$@"
}}
)zsh";

constexpr const char* kTail = R"zsh(
if [ "$funcstack[1]" = "_scanknit" ]; then
  _scanknit "$@"
else
  compdef _scanknit scanknit
fi
)zsh";

/// Escapes text for the explanations of _arguments and _describe, in single quotes.
std::string zsh_quoted(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
      continue;
    }
    if (c == '\\' || c == '[' || c == ']' || c == ':') result += '\\';
    result += c;
  }
  return result;
}

/// The action of _arguments that completes a value. A leading space makes _arguments call the words unchanged.
std::string action(const OptionDescription& option) {
  if (option.kind == ValueKind::kFolder) return "_files -/";
  if (option.words.empty()) return option.kind == ValueKind::kFile ? "_files" : "";
  const std::string words = fmt::format("{}", fmt::join(option.words, " "));
  if (option.kind == ValueKind::kFile) return " _scanknit_words_or_files " + words;
  return option.words.front().ends_with('=') ? " _scanknit_keys " + words : "(" + words + ")";
}

std::string option_lines(const OptionDescription& option) {
  std::string lines;
  const std::string exclusion =
      option.is_repeatable ? "*" : fmt::format("({})", fmt::join(option.names, " "));  // may be given only once
  for (const std::string& name : option.names) {
    const char* joint = name.starts_with("--") ? "=" : "+";  // --name=value, -nvalue
    lines += fmt::format(" \\\n    '{}{}", exclusion, name);
    if (option.kind != ValueKind::kFlag) lines += joint;
    lines += fmt::format("[{}]", zsh_quoted(option.text));
    if (option.kind != ValueKind::kFlag) lines += fmt::format(":{}:{}", zsh_quoted(option.value), action(option));
    lines += "'";
  }
  return lines;
}

std::string argument_line(const OptionDescription& argument, std::size_t place) {
  const std::string where = argument.is_repeatable ? "*" : std::to_string(place);
  return fmt::format(" \\\n    '{}:{}:{}'", where, zsh_quoted(argument.value), action(argument));
}

std::string function_name(const std::string& parent, const CommandDescription& command) {
  std::string name = parent + "_" + command.name;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

/// The functions of the subcommands, then that of the command itself.
std::string functions(const std::string& parent, const CommandDescription& command) {
  const std::string name = function_name(parent, command);
  std::string text, lines, names, cases;
  for (const CommandDescription& below : command.commands) {
    text += functions(name, below);
    names += fmt::format("\n        '{}:{}'", below.name, zsh_quoted(below.text));
    cases += fmt::format("\n        {}) {} ;;", below.name, function_name(name, below));
  }
  for (const OptionDescription& option : command.options) lines += option_lines(option);
  for (std::size_t i = 0; i < command.arguments.size(); ++i) lines += argument_line(command.arguments[i], i + 1);
  if (command.commands.empty()) return text + fmt::format("\n{}() {{\n  _arguments -s{}\n}}\n", name, lines);
  return text + fmt::format(R"zsh(
{}() {{
  local curcontext="$curcontext" context state state_descr line
  typeset -A opt_args
  _arguments -C -s{} \
    '1:command:->command' \
    '*::argument:->argument'
  case $state in
    command)
      local -a commands
      commands=({}
      )
      _describe -t commands command commands
      ;;
    argument)
      case $line[1] in{}
      esac
      ;;
  esac
}}
)zsh",
                            name, lines, names, cases);
}

}  // namespace

std::string zsh_completion(const CommandDescription& program) {
  return fmt::format(kHead, kVersion) + functions("", program) + kTail;
}

}  // namespace scanknit
