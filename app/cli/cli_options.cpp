#include "app/cli/cli_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "app/config/config_schema.h"
#include "app/config/presets.h"
#include "app/config/volume_arguments.h"
#include "extract/volume/sample_type.h"

namespace scanknit {
namespace {

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.emplace_back(preset.name);
  return names;
}

/// An option whose text `parse` converts; the value goes to `place`.
template <typename Value, typename Parse>
CLI::Option* add_parsed(CLI::App& app, const OptionText& text, Value& place, const Parse& parse,
                        const std::string& expected) {
  const auto assign = [&place, parse, name = text.name, expected](const std::string& given) {
    const auto value = parse(given);
    if (!value) throw CLI::ValidationError(name, "expected " + expected + ", got '" + given + "'");
    place = *value;
  };
  return app.add_option_function<std::string>(text.name, assign, text.help)->group("Raw samples and stacks of images");
}

std::optional<ByteOrder> byte_order_named(std::string_view name) {
  if (name == "little") return ByteOrder::kLittle;
  if (name == "big") return ByteOrder::kBig;
  return std::nullopt;
}

/// Why the text is not a finite number: "nan" would pass checks of both limits.
std::string why_not_finite(const std::string& text) {
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "expected a finite number, got '" + text + "'";
}

}  // namespace

/// `--name VALUE` as a short form of `--set key=VALUE`.
CLI::Option* add_shorthand(CLI::App& app, CommandLine& line, const std::string& name, const std::string& key,
                           const std::string& text) {
  const auto assign = [&line, key](const std::string& value) {
    line.common.config.assignments.push_back(key + "=" + value);
  };
  CLI::Option* option = app.add_option_function<std::string>(name, assign, text + " (" + key + ")");
  if (const ConfigKey* described = find_config_key(key)) {
    line.words[option] = described->choices;
    if (described->allows_auto) line.words[option].emplace_back("auto");
  }
  return option;
}

void add_volume_options(CLI::App& app, CommandLine& line, VolumeOptions& options) {
  const std::vector<std::string> orders = {"little", "big"};
  auto* dims = add_parsed(app, {"--dims", "Raw file: samples along i (fastest), j, k"}, options.dims, parse_dims,
                          "samples such as 256x256x108")
                   ->type_name("NXxNYxNZ");
  auto* type = add_parsed(app, {"--type", "Raw file: its samples"}, options.type, sample_type_named,
                          fmt::format("one of {}", fmt::join(kSampleTypeNames, ", ")))
                   ->needs(dims)
                   ->type_name("TYPE");
  line.words[type].assign(kSampleTypeNames.begin(), kSampleTypeNames.end());
  add_parsed(app, {"--spacing", "Raw file or folder of images: millimetres between samples"}, options.spacing,
             parse_spacing, "millimetres such as 0.5 or 0.5x0.5x1.2")
      ->type_name("MM|XxYxZ");
  auto* order = add_parsed(app, {"--byte-order", "Raw file: little or big"}, options.byte_order, byte_order_named,
                           "little or big")
                    ->needs(dims)
                    ->type_name("ORDER");
  line.words[order] = orders;
  add_parsed(app, {"--header-bytes", "Raw file: bytes before the first sample"}, options.header_bytes,
             parse_header_bytes, "a whole number of bytes, 0 or more")
      ->needs(dims)
      ->type_name("N");
}

void add_common(CLI::App& app, CommandLine& line) {
  ConfigSources& config = line.common.config;
  app.add_option("--config", config.file, "Configuration file (YAML)")->type_name("FILE")->group("Configuration");
  const std::vector<std::string> names = preset_names();
  auto* preset = app.add_option("--preset", config.presets,
                                fmt::format("Built-in configuration, may be repeated: {}", fmt::join(names, ", ")))
                     ->type_name("NAME")
                     ->allow_extra_args(false)
                     ->group("Configuration");
  line.words[preset] = names;
  // Appends, because the shorthands add to the same list.
  const auto append = [&config](const std::vector<std::string>& values) {
    config.assignments.insert(config.assignments.end(), values.begin(), values.end());
  };
  auto* set = app.add_option_function<std::vector<std::string>>(
                     "--set", append, "One value, may be repeated: --set fusion.voxel_size=2mm")
                  ->type_name("KEY=VALUE")
                  ->allow_extra_args(false)
                  ->group("Configuration");
  for (const ConfigKey& key : config_schema()) line.words[set].push_back(key.name + "=");
  app.add_option("--threads", line.common.threads, "Threads to use; the result does not depend on it")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->group("General");
  app.add_flag("--json", line.common.is_json, "Print the result as JSON")->group("General");
  auto* quiet = app.add_flag("-q,--quiet", line.is_quiet, "Say errors only")->group("General");
  app.add_flag("-v,--verbose", line.is_verbose, "Say more")->excludes(quiet)->group("General");
}

void add_output_options(CLI::App& app, OutputRequest& outputs) {
  app.add_option("-o,--output", outputs.output, "Folder, or one file (.glb .ply .obj .stl .3mf .tiles)")
      ->required()
      ->type_name("OUT");
  app.add_option("--report", outputs.report, "Write report.json here")->type_name("FILE");
  if (!outputs.has_trajectory) return;
  app.add_option("--trajectory", outputs.trajectory, "Write the poses here (TUM format; .kitti, .json)")
      ->type_name("FILE");
  app.add_option("--save-volume", outputs.volume, "Write the volume here (OpenVDB)")->type_name("FILE.vdb");
}

void add_server_options(CLI::App& app, LiveViewOptions& server, CLI::Option* needed) {
  const auto set_port = [&server](const std::uint16_t& port) { server.port = port; };
  auto* address =
      app.add_option("--listen", server.address,
                     "Address of this computer that the page is served on, 0.0.0.0 for all; default: "
                     "127.0.0.1, this computer only. Unless it is a loopback address, the link has a token, "
                     "without which nothing is shown")
          ->type_name("ADDRESS")
          ->group("Live view");
  auto* port = app.add_option_function<std::uint16_t>("--port", set_port, "Default: 8765, or any free one; 0: any")
                   ->type_name("PORT")
                   ->group("Live view");
  if (needed == nullptr) return;
  address->needs(needed);
  port->needs(needed);
}

void add_view_options(CLI::App& app, ViewArguments& view) {
  auto* wanted =
      app.add_flag("--view", view.is_wanted, "Show the mesh in a browser while it grows")->group("Live view");
  add_server_options(app, view.server, wanted);
}

void add_scanner_options(CLI::App& app, ScannerRequest& scanner) {
  const std::string group = "Scanner";
  app.add_option("--device", scanner.device, "Which scanner, as `scanknit devices` lists it; default: the first")
      ->type_name("URI")
      ->group(group);
  app.add_option("--width", scanner.width, "Width of the depth pictures; the camera's nearest is used")
      ->check(CLI::Range(16, 8192))
      ->group(group);
  app.add_option("--height", scanner.height, "Height of the depth pictures")->check(CLI::Range(16, 8192))->group(group);
  app.add_option("--fps", scanner.frames_per_second, "Pictures a second")
      ->check(why_not_finite)
      ->check(CLI::Range(1.0, 1000.0))
      ->group(group);
  auto* frames = app.add_option("--frames", scanner.frames, "Stop after N depth pictures")
                     ->check(CLI::Range(1, 100'000'000))
                     ->type_name("N")
                     ->group(group);
  app.add_option("--seconds", scanner.seconds, "Stop S seconds after the first picture")
      ->check(why_not_finite)
      ->check(CLI::Range(0.001, 1e9))
      ->excludes(frames)
      ->type_name("S")
      ->group(group);
  app.add_option("--wait", scanner.wait_s, "Wait S seconds for a scanner that is not plugged in yet")
      ->check(why_not_finite)
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("S")
      ->group(group);
  app.add_option("--reconnect", scanner.reconnect_s,
                 "Wait S seconds for a scanner that was unplugged, default 30; 0: the scan ends")
      ->check(why_not_finite)
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("S")
      ->group(group);
  app.add_flag("--force", scanner.takes_from_others, "Use the scanner even if another program uses it")->group(group);
}

void add_export_options(CLI::App& app, ConfigSources& config) {
  const auto add = [&](const std::string& name, const std::string& key, const std::string& words) {
    const auto set = [&config, key] { config.assignments.push_back(key + "=true"); };
    app.add_flag_callback(name, set, words + " (" + key + ")")->group("Smaller GLB files");
  };
  add("--quantize", "export.quantize", "Positions and normals as small integers: four fifths of the size");
  add("--compress", "export.compress",
      "For the web: half the size, with --quantize a quarter; Blender and Assimp do not read it");
}

CLI::Option* add_texture_option(CLI::App& app, ConfigSources& config) {
  const auto set = [&config] { config.assignments.emplace_back("export.texture=png"); };
  return app.add_flag_callback("--texture", set,
                               "GLB with a texture from the colour frames, finer than its vertices (export.texture)");
}

void add_refused_texture_option(CLI::App& app, ConfigSources& config) {
  add_texture_option(app, config)->group("");
}

}  // namespace scanknit
