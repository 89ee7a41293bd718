#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "app/cli/completion.h"
#include "core/version.h"

namespace scanknit {
namespace {

/// Does not need the package bash-completion. The generated `cases`, which go before it, say what each command takes.
constexpr const char* kScript =
    R"bash(# Completion of scanknit {version} for bash, written by `scanknit completion bash`.

_scanknit_values() {{
  # How the value of "$2", an option of the command "$1", is completed: sets kind and words.
  kind="" words=""
  case "$1 $2" in
{values}  esac
}}

_scanknit_command() {{
  # What the command "$1" takes: sets options, argument (how it is completed) and words.
  options="" argument="" words=""
  case "$1" in
{commands}  esac
}}

_scanknit() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD - 1]}}"
  local path="" word kind words options argument
  COMPREPLY=()
  # --option=value arrives as three words.
  if [[ "$current" == "=" || "$previous" == "=" ]]; then
    [[ "$current" == "=" ]] || previous="${{COMP_WORDS[COMP_CWORD - 2]}}"
    [[ "$current" != "=" ]] || current=""
    [[ "$previous" == -* ]] || return 0
  fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "${{path:+$path }}$word" in
      {paths}) path="${{path:+$path }}$word" ;;
      *) break ;;
    esac
  done
  _scanknit_values "$path" "$previous"
  if [[ -z "$kind" ]]; then
    _scanknit_command "$path"
    if [[ "$current" == -* ]]; then
      kind=words words="$options"
    else
      kind="$argument"
    fi
  fi
  if [[ -n "$words" && "$kind" != nothing ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    [[ "${{#COMPREPLY[@]}}" -ne 1 || "${{COMPREPLY[0]}}" != *= ]] || compopt -o nospace 2>/dev/null
  fi
  case "$kind" in
    files)
      compopt -o filenames 2>/dev/null
      mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$current")
      ;;
    folders)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -d -- "$current")
      ;;
  esac
  return 0
}}

complete -F _scanknit scanknit
)bash";

const char* kind_name(const OptionDescription& option) {
  switch (option.kind) {
    case ValueKind::kFile: return "files";
    case ValueKind::kFolder: return "folders";
    case ValueKind::kOther:
    case ValueKind::kFlag: return option.words.empty() ? "nothing" : "words";
  }
  return "nothing";
}

struct Parts {
  std::string values, commands;
  std::vector<std::string> paths;
};

void add_command(const CommandDescription& command, const std::string& path, Parts& parts) {
  std::vector<std::string> names;
  for (const OptionDescription& option : command.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
    if (option.kind == ValueKind::kFlag) continue;
    std::vector<std::string> patterns;
    for (const std::string& name : option.names) patterns.push_back(fmt::format("\"{} {}\"", path, name));
    parts.values += fmt::format("    {}) kind={} words=\"{}\" ;;\n", fmt::join(patterns, " | "), kind_name(option),
                                fmt::join(option.words, " "));
  }
  std::string argument = "nothing";
  std::vector<std::string> words;
  for (const CommandDescription& below : command.commands) words.push_back(below.name);
  if (!words.empty()) argument = "words";
  if (!command.arguments.empty()) {  // all arguments of a command are of the same kind
    argument = kind_name(command.arguments.front());
    words = command.arguments.front().words;
  }
  parts.commands += fmt::format("    \"{}\") options=\"{}\" argument={} words=\"{}\" ;;\n", path, fmt::join(names, " "),
                                argument, fmt::join(words, " "));
  for (const CommandDescription& below : command.commands) {
    const std::string below_path = path.empty() ? below.name : path + " " + below.name;
    parts.paths.push_back("\"" + below_path + "\"");
    add_command(below, below_path, parts);
  }
}

}  // namespace

std::string bash_completion(const CommandDescription& program) {
  Parts parts;
  add_command(program, "", parts);
  return fmt::format(kScript, fmt::arg("version", kVersion), fmt::arg("values", parts.values),
                     fmt::arg("commands", parts.commands), fmt::arg("paths", fmt::join(parts.paths, " | ")));
}

}  // namespace scanknit
