// The options that several commands share, and the building blocks of options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/command_line.h"

namespace scanknit {

/// `--name VALUE` as a short form of `--set key=VALUE`.
CLI::Option* add_shorthand(CLI::App& app, CommandLine& line, const std::string& name, const std::string& key,
                           const std::string& text);

/// An option's name, as of "--pace", and its text in the help.
struct OptionText {
  std::string name, help;
};

/// An option whose value is one of a few words.
template <typename Value>
CLI::Option* add_choice(CLI::App& app, CommandLine& line, const OptionText& text, Value& place,
                        const std::vector<std::pair<std::string, Value>>& choices) {
  const auto assign = [&place, name = text.name, choices](const std::string& given) {
    std::string words;
    for (const auto& [word, value] : choices) {
      if (word == given) {
        place = value;
        return;
      }
      words += (words.empty() ? "" : ", ") + word;
    }
    throw CLI::ValidationError(name, "expected one of " + words + ", got '" + given + "'");
  };
  CLI::Option* option = app.add_option_function<std::string>(text.name, assign, text.help);
  for (const auto& choice : choices) line.words[option].push_back(choice.first);
  return option;
}

/// The options of every command: configuration, threads, verbosity.
void add_common(CLI::App& app, CommandLine& line);

/// `-o` and other paths of a command that writes a mesh. Paths of poses and volume only if `outputs.has_trajectory`.
void add_output_options(CLI::App& app, OutputRequest& outputs);

/// How to read raw samples and stacks of images.
void add_volume_options(CLI::App& app, CommandLine& line, VolumeOptions& options);

/// Which scanner, its pictures, and when the scan ends.
void add_scanner_options(CLI::App& app, ScannerRequest& scanner);

/// The address of the live view. `needed`: the option that these require; may be null.
void add_server_options(CLI::App& app, LiveViewOptions& server, CLI::Option* needed);

/// `--view` and the options of its address.
void add_view_options(CLI::App& app, ViewArguments& view);

/// `--quantize` and `--compress`, of a command that writes a GLB.
void add_export_options(CLI::App& app, ConfigSources& config);

/// `--texture`, of a command that has colour frames.
CLI::Option* add_texture_option(CLI::App& app, ConfigSources& config);

/// `--texture`, hidden, for commands without colour frames: these explain why they make none (refuse_texture()).
void add_refused_texture_option(CLI::App& app, ConfigSources& config);

}  // namespace scanknit
