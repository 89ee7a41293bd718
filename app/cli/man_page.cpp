#include "app/cli/man_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/exit_codes.h"
#include "core/version.h"

namespace scanknit {
namespace {

/// Escapes text for troff. `code` becomes bold.
std::string escaped(const std::string& text) {
  std::string result;
  bool is_bold = false;
  for (const char c : text) {
    switch (c) {
      case '\\': result += "\\e"; break;
      case '-': result += "\\-"; break;
      case '\'': result += "\\(aq"; break;
      case '`':
        is_bold = !is_bold;
        result += is_bold ? "\\fB" : "\\fR";
        break;
      default: result += c;
    }
  }
  // A line that begins with a dot would be a request.
  return result.starts_with('.') ? "\\&" + result : result;
}

std::string bold(const std::string& text) {
  return "\\fB" + escaped(text) + "\\fR";
}

std::string italic(const std::string& text) {
  return "\\fI" + escaped(text) + "\\fR";
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

/// The limits and words of a value, if the option's text does not name them.
std::string values_text(const OptionDescription& option) {
  std::string text;
  if (!option.limits.empty()) text += " (" + escaped(option.limits) + ")";
  const bool is_said = std::all_of(option.words.begin(), option.words.end(), [&](const std::string& word) {
    return option.text.find(word) != std::string::npos;
  });
  if (is_said || option.words.front().ends_with('=')) return text;
  return text + fmt::format(".\nOne of {}", escaped(fmt::format("{}", fmt::join(option.words, ", "))));
}

std::string option_text(const OptionDescription& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back(bold(name));
  std::string head = fmt::format("{}", fmt::join(names, ", "));
  if (option.kind != ValueKind::kFlag) head += (names.empty() ? "" : " ") + italic(option.value);
  std::string text = escaped(option.text) + values_text(option);
  if (option.is_required && !option.names.empty()) text += " (required)";
  return ".TP\n" + head + "\n" + text + (text.ends_with('.') ? "\n" : ".\n");
}

/// The options, group by group, in the order of --help.
std::string options_text(const CommandDescription& command) {
  std::vector<std::string> groups;
  for (const OptionDescription& option : command.options) {
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  }
  std::string text = command.options.empty() ? "" : ".SH OPTIONS\n";
  for (const std::string& group : groups) {
    if (group != "Options") text += fmt::format(".SS \"{}\"\n", escaped(group));
    for (const OptionDescription& option : command.options) {
      if (option.group == group) text += option_text(option);
    }
  }
  return text;
}

std::string synopsis(const CommandDescription& command, const std::string& words) {
  std::string text = ".SH SYNOPSIS\n" + bold(words);
  for (const OptionDescription& option : command.options) {
    if (option.is_required) text += " " + bold(option.names.back()) + " " + italic(option.value);
  }
  for (const OptionDescription& argument : command.arguments) {
    text += argument.is_required ? " " + italic(argument.value) : " [" + italic(argument.value) + "]";
  }
  text += " [" + italic("OPTION") + "]...";
  if (!command.commands.empty()) text += "\n.br\n" + bold(words) + " " + italic("COMMAND") + " ...";
  return text + "\n";
}

std::string exit_status() {
  std::string text = ".SH \"EXIT STATUS\"\n";
  for (const ExitCode& exit : kExitCodes) {
    text += fmt::format(".TP\n.B {}\n{}.\n", exit.code, escaped(std::string(exit.text)));
  }
  return text;
}

constexpr const char* kEnvironmentAndFiles = R"(.SH ENVIRONMENT
.TP
.B NO_COLOR
When set and not empty, messages have no colours.
.SH FILES
Under the prefix of the installation:
.TP
.I share/scanknit/configs/*.yaml
The presets that \fB\-\-preset\fR names. They are built in; the files are to be read and copied.
.TP
.I lib/udev/rules.d/60\-scanknit.rules
Lets whoever sits at the computer use the scanners; as \fBscanknit udev\-rules\fR prints it.
.SH EXAMPLES
.nf
scanknit synth turntable \-\-frames 120 \-\-noise \-o recording
scanknit run recording \-\-preset object \-o out
scanknit capture \-o out \-\-preset turntable \-\-view
.fi
)";

void add_page(const CommandDescription& command, const std::string& parent, const std::string& see_also,
              std::vector<ManPage>& pages) {
  const std::string words = parent.empty() ? command.name : parent + " " + command.name;
  std::string name = words;
  std::replace(name.begin(), name.end(), ' ', '-');
  std::string text =
      fmt::format(".TH \"{}\" 1 \"{}\" \"scanknit {}\" \"ScanKnit\"\n.SH NAME\n{} \\- {}\n", upper(escaped(name)),
                  escaped(kReleaseDate), kVersion, escaped(name), escaped(command.text));
  text += synopsis(command, words);
  if (!command.arguments.empty()) text += ".SH ARGUMENTS\n";
  for (const OptionDescription& argument : command.arguments) text += option_text(argument);
  if (!command.commands.empty()) text += ".SH COMMANDS\n";
  std::vector<std::string> below_names;
  for (const CommandDescription& below : command.commands) {
    text += fmt::format(".TP\n{}\n{}.\n", bold(below.name), escaped(below.text));
    below_names.push_back(fmt::format(".BR {} (1)", escaped(name + "-" + below.name)));
  }
  text += options_text(command) + exit_status();
  if (parent.empty()) text += kEnvironmentAndFiles;
  text += ".SH \"SEE ALSO\"\n";
  text += below_names.empty() ? see_also : fmt::format("{}\n", fmt::join(below_names, ",\n"));
  pages.push_back({name + ".1", text});
  for (const CommandDescription& below : command.commands) {
    add_page(below, words, fmt::format(".BR {} (1)\n", escaped(name)), pages);
  }
}

}  // namespace

std::vector<ManPage> man_pages(const CommandDescription& program) {
  std::vector<ManPage> pages;
  add_page(program, "", "", pages);
  return pages;
}

}  // namespace scanknit
