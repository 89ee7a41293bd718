#include "app/cli.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/cli_align.h"
#include "app/cli_export.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/presets.h"
#include "app/quantity.h"
#include "app/rig_options.h"
#include "app/suggestion.h"
#include "app/volume_arguments.h"
#include "core/version.h"

namespace scanknit {
namespace {

/// The parsed command line, and the command that was chosen.
struct CommandLine {
  CommonArguments common;
  RunArguments run;
  CaptureArguments capture;
  RecordArguments record;
  ShowArguments show;
  ReportArguments report;
  ExtractArguments extract;
  AlignArguments align;
  SynthArguments synth;
  ConfigArguments config;
  InfoArguments info;
  ConvertArguments convert;
  RepairArguments repair;
  DistanceArguments distance;
  std::string rules_device;
  std::size_t threads = 0;  ///< 0: as many as the machine has
  bool is_quiet = false, is_verbose = false;
  std::function<int()> command;
};

std::string preset_names() {
  std::string names;
  for (const Preset& preset : presets()) names += (names.empty() ? "" : ", ") + std::string(preset.name);
  return names;
}

/// `--name VALUE` as a short form of `--set key=VALUE`.
CLI::Option* add_shorthand(CLI::App& app, CommandLine& line, const std::string& name, const std::string& key,
                           const std::string& text) {
  const auto assign = [&line, key](const std::string& value) {
    line.common.config.assignments.push_back(key + "=" + value);
  };
  return app.add_option_function<std::string>(name, assign, text + " (" + key + ")");
}

/// An option whose text `parse` turns into the value of `place`.
template <typename Value, typename Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Value& place, const Parse& parse,
                        const std::string& expected, const std::string& text) {
  const auto assign = [&place, parse, name, expected](const std::string& given) {
    const auto value = parse(given);
    if (!value) throw CLI::ValidationError(name, "expected " + expected + ", got '" + given + "'");
    place = *value;
  };
  return app.add_option_function<std::string>(name, assign, text)->group("Raw samples and stacks of images");
}

/// An option that is one of a few words.
template <typename Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& place,
                        const std::vector<std::pair<std::string, Value>>& choices, const std::string& text) {
  const auto assign = [&place, name, choices](const std::string& given) {
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
  return app.add_option_function<std::string>(name, assign, text);
}

std::optional<ByteOrder> byte_order_named(std::string_view name) {
  if (name == "little") return ByteOrder::kLittle;
  if (name == "big") return ByteOrder::kBig;
  return std::nullopt;
}

void add_volume_options(CLI::App& app, VolumeOptions& options) {
  auto* dims = add_parsed(app, "--dims", options.dims, parse_dims, "samples such as 256x256x108",
                          "Raw file: samples along i (fastest), j, k")
                   ->type_name("NXxNYxNZ");
  add_parsed(app, "--type", options.type, sample_type_named,
             "one of int8, uint8, int16, uint16, int32, uint32, int64, uint64, float, double", "Raw file: its samples")
      ->needs(dims)
      ->type_name("TYPE");
  add_parsed(app, "--spacing", options.spacing, parse_spacing, "millimetres such as 0.5 or 0.5x0.5x1.2",
             "Raw file or folder of images: millimetres between samples")
      ->type_name("MM|XxYxZ");
  add_parsed(app, "--byte-order", options.byte_order, byte_order_named, "little or big", "Raw file: little or big")
      ->needs(dims)
      ->type_name("ORDER");
  add_parsed(app, "--header-bytes", options.header_bytes, parse_header_bytes, "a whole number of bytes, 0 or more",
             "Raw file: bytes before the first sample")
      ->needs(dims)
      ->type_name("N");
}

void add_common(CLI::App& app, CommandLine& line) {
  ConfigSources& config = line.common.config;
  app.add_option("--config", config.file, "Configuration file (YAML)")->type_name("FILE")->group("Configuration");
  app.add_option("--preset", config.presets, "Built-in configuration, may be repeated: " + preset_names())
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group("Configuration");
  // Appended, not assigned: the shorthands above put theirs into the same list.
  const auto append = [&config](const std::vector<std::string>& values) {
    config.assignments.insert(config.assignments.end(), values.begin(), values.end());
  };
  app.add_option_function<std::vector<std::string>>("--set", append,
                                                    "One value, may be repeated: --set fusion.voxel_size=2mm")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->group("Configuration");
  app.add_option("--threads", line.threads, "Threads to use; the result does not depend on it")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->group("General");
  app.add_flag("--json", line.common.is_json, "Print the result as JSON")->group("General");
  auto* quiet = app.add_flag("-q,--quiet", line.is_quiet, "Say errors only")->group("General");
  app.add_flag("-v,--verbose", line.is_verbose, "Say more")->excludes(quiet)->group("General");
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

/// Of one object, walked round or turned.
bool is_orbit(const ConfigSources& config) {
  const auto& presets = config.presets;
  return std::any_of(presets.begin(), presets.end(),
                     [](const std::string& name) { return name == "object" || name == "turntable"; });
}

void add_run(CLI::App& app, CommandLine& line) {
  RunArguments& run = line.run;
  CLI::App* command = app.add_subcommand("run", "Fuse a recording and write the mesh");
  command->add_option("recording", run.recording, "Folder or file of the recording")
      ->required()
      ->type_name("RECORDING");
  command->add_option("-o,--output", run.output, "Folder, or one file (.glb .ply .obj .stl .3mf)")
      ->required()
      ->type_name("OUT");
  command->add_option("--from", run.from, "First frame, counting from 0")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command->add_option("--to", run.to, "Last frame, included")->check(CLI::NonNegativeNumber)->type_name("N");
  command->add_option("--every", run.every, "Take every N-th frame")->check(CLI::Range(1, 1'000'000))->type_name("N");
  add_choice(*command, "--pace", run.pace,
             {{"fast", Pace::kFast}, {"realtime", Pace::kRealtime}, {"stepped", Pace::kStepped}},
             "fast; realtime: by the recording's clock; stepped: a frame for each Enter; the mesh is the same")
      ->type_name("PACE");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording");
  add_shorthand(*command, line, "--poses", "acquire.poses",
                "Where poses come from: auto, recording, track, refine, still");
  command->add_option("--report", run.report, "Write report.json here")->type_name("FILE");
  command->add_option("--trajectory", run.trajectory, "Write the poses here (TUM format)")->type_name("FILE");
  command->add_option("--save-volume", run.volume, "Write the volume here (OpenVDB)")->type_name("FILE.vdb");
  add_turntable_options(*command, run);
  add_export_options(*command, line.common.config);
  add_view_options(*command, run.view);
  add_common(*command, line);
  command->final_callback([&line] {
    line.run.view.is_orbit = is_orbit(line.common.config);
    line.command = [&line] { return run_command(line.run, line.common); };
  });
}

/// "nan" is neither below nor above any limit.
std::string why_not_finite(const std::string& text) {
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "expected a finite number, got '" + text + "'";
}

void add_scanner_options(CLI::App& app, ScannerArguments& scanner) {
  const std::string group = "Scanner";
  app.add_option("--device", scanner.device, "Which scanner, as `scanknit devices` lists it; default: the first")
      ->type_name("URI")
      ->group(group);
  app.add_option("--width", scanner.width, "Width of the depth pictures, or the nearest there is")
      ->check(CLI::Range(16, 8192))
      ->group(group);
  app.add_option("--height", scanner.height, "Height of the depth pictures")->check(CLI::Range(16, 8192))->group(group);
  app.add_option("--fps", scanner.frames_per_second, "Pictures a second")
      ->check(why_not_finite)
      ->check(CLI::Range(1.0, 1000.0))
      ->group(group);
  auto* frames = app.add_option("--frames", scanner.frames, "End after so many depth pictures")
                     ->check(CLI::Range(1, 100'000'000))
                     ->type_name("N")
                     ->group(group);
  app.add_option("--seconds", scanner.seconds, "End after so long")
      ->check(why_not_finite)
      ->check(CLI::PositiveNumber)
      ->excludes(frames)
      ->type_name("S")
      ->group(group);
  app.add_option("--wait", scanner.wait_s, "Wait so many seconds for a scanner that is not plugged in yet")
      ->check(why_not_finite)
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->group(group);
  app.add_option("--reconnect", scanner.reconnect_s,
                 "Wait so many seconds for a scanner that was unplugged, default 30; 0: the scan ends")
      ->check(why_not_finite)
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->group(group);
  app.add_flag("--force", scanner.takes_from_others, "Also a scanner that another program uses")->group(group);
}

void add_capture(CLI::App& app, CommandLine& line) {
  CaptureArguments& capture = line.capture;
  CLI::App* command = app.add_subcommand("capture", "Scan with a scanner that is plugged in, and write the mesh");
  command->add_option("-o,--output", capture.output, "Folder, or one file (.glb .ply .obj .stl .3mf)")
      ->required()
      ->type_name("OUT");
  add_scanner_options(*command, capture.scanner);
  auto* recording = command->add_option("--recording", capture.recording, "Keep the raw pictures here (default: OUT)")
                        ->type_name("FILE.mcap");
  command->add_flag("!--no-recording", capture.wants_recording, "Do not keep the raw pictures")->excludes(recording);
  add_shorthand(*command, line, "--poses", "acquire.poses", "track (the default), or still");
  command->add_option("--report", capture.report, "Write report.json here")->type_name("FILE");
  command->add_option("--trajectory", capture.trajectory, "Write the poses here (TUM format)")->type_name("FILE");
  command->add_option("--save-volume", capture.volume, "Write the volume here (OpenVDB)")->type_name("FILE.vdb");
  add_export_options(*command, line.common.config);
  add_view_options(*command, capture.view);
  add_common(*command, line);
  command->final_callback([&line] {
    line.capture.view.is_orbit = is_orbit(line.common.config);
    line.command = [&line] { return capture_command(line.capture, line.common); };
  });
}

void add_view(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("view", "Show a mesh in a browser");
  command->add_option("file", line.show.file, "A mesh (.glb .ply .obj .stl), or the folder that `run` wrote one into")
      ->required()
      ->type_name("FILE|OUT");
  add_server_options(*command, line.show.server, nullptr);
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return view_command(line.show, line.common); }; });
}

void add_record(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("record", "Keep what a scanner sends, for `run`");
  command->add_option("-o,--output", line.record.output, "The recording")->required()->type_name("FILE.mcap");
  add_scanner_options(*command, line.record.scanner);
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return record_command(line.record, line.common); }; });
}

void add_extract(CLI::App& app, CommandLine& line) {
  ExtractArguments& extract = line.extract;
  CLI::App* command = app.add_subcommand("extract", "Mesh a volume: its isosurface");
  command
      ->add_option("volume", extract.volume,
                   "OpenVDB, NRRD, MetaImage, NIfTI, raw samples, or a folder of DICOM, PNG or TIFF slices")
      ->required()
      ->type_name("VOLUME");
  command->add_option("-o,--output", extract.output, "Folder, or one file (.glb .ply .obj .stl .3mf)")
      ->required()
      ->type_name("OUT");
  command->add_option("--report", extract.report, "Write report.json here")->type_name("FILE");
  auto* isovalue = add_shorthand(*command, line, "--isovalue", "extract.isovalue", "Value of the surface");
  command->add_flag("--auto-isovalue", extract.wants_auto_isovalue, "Propose a value from the volume's (Otsu 1979)")
      ->excludes(isovalue);
  command->add_flag("--stats", extract.wants_stats, "Print how often each configuration and sub-case occurred");
  add_shorthand(*command, line, "--decider", "extract.decider", "How ambiguous cells are resolved");
  add_shorthand(*command, line, "--inside", "extract.inside", "Which side is matter: auto, low, high");
  add_volume_options(*command, extract.options);
  add_export_options(*command, line.common.config);
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return extract_command(line.extract, line.common); }; });
}

void add_align(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("align", "Bring several scans of one thing together, and write one mesh");
  add_align_options(*command, line.align);
  add_export_options(*command, line.common.config);
  add_shorthand(*command, line, "--poses", "acquire.poses", "Where the poses of a recording's own frames come from");
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return align_command(line.align, line.common); }; });
}

void add_synth(CLI::App& app, CommandLine& line) {
  SynthArguments& synth = line.synth;
  CLI::App* command = app.add_subcommand("synth", "Scan a scene that is known exactly, for tests and demonstrations");
  auto* scene =
      command->add_option("scene", synth.scene, "Name of a scene (--list), or a closed mesh file")->type_name("SCENE");
  auto* output = command->add_option("-o,--output", synth.output, "Folder of the new recording")->type_name("DIR");
  command->add_option("--frames", synth.frames, "Number of frames")->check(CLI::Range(1, 100'000))->type_name("N");
  command->add_option("--width", synth.width, "Width of the pictures, pixels")->check(CLI::Range(16, 4096));
  command->add_option("--height", synth.height, "Height of the pictures, pixels")->check(CLI::Range(16, 4096));
  command->add_flag("--noise", synth.has_noise, "Noise like a Kinect's");
  command->add_option("--seed", synth.seed, "Seed of the noise")->check(CLI::NonNegativeNumber)->type_name("N");
  command->add_flag("--jpeg", synth.has_jpeg_colour, "Colour pictures as JPEG, smaller than PNG");
  const auto set_size = [&synth](const std::string& text) {
    const auto length = parse_length(text);
    if (!length || length->metres <= 0) throw CLI::ValidationError("--size", "expected a length such as 20cm, 0.2");
    synth.size_m = length->metres;
  };
  command->add_option_function<std::string>("--size", set_size, "Longest side of a mesh: 20cm")->type_name("LENGTH");
  add_rig_options(*command, synth);
  command->add_flag("--list", synth.only_list, "List the scenes")->excludes(scene)->excludes(output);
  add_common(*command, line);
  command->final_callback([&line] {
    const SynthArguments& given = line.synth;
    if (!given.only_list && given.scene.empty()) throw CLI::RequiredError("SCENE (or --list)");
    if (!given.only_list && given.output.empty()) throw CLI::RequiredError("--output");
    line.command = [&line] { return synth_command(line.synth, line.common); };
  });
}

void add_convert(CLI::App& app, CommandLine& line) {
  ConvertArguments& convert = line.convert;
  CLI::App* command = app.add_subcommand("convert", "Write a recording in another layout");
  command->add_option("recording", convert.recording, "Folder or file of the recording")
      ->required()
      ->type_name("RECORDING");
  command->add_option("-o,--output", convert.output, "A file (mcap), or a new folder")->required()->type_name("OUT");
  add_choice(*command, "--to", convert.target,
             {{"mcap", ConvertTarget::kMcap},
              {"tum", ConvertTarget::kTum},
              {"open3d", ConvertTarget::kOpen3d},
              {"7-scenes", ConvertTarget::kSevenScenes},
              {"fakenect", ConvertTarget::kFakenect}},
             "mcap, tum, open3d, 7-scenes, fakenect")
      ->required()
      ->type_name("LAYOUT");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording that is read");
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return convert_command(line.convert, line.common); }; });
}

void add_repair(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("repair", "Mend a recording (.mcap) that was cut short or damaged");
  command->add_option("file", line.repair.file, "The recording")->required()->type_name("FILE.mcap");
  command->add_option("-o,--output", line.repair.output, "Write the mended recording here, not in its place")
      ->type_name("OUT.mcap");
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return repair_command(line.repair, line.common); }; });
}

void add_info(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("info", "Describe a recording, a volume or a mesh");
  command->add_option("file", line.info.file, "What to describe")->required()->type_name("FILE");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording");
  add_volume_options(*command, line.info.options);
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return info_command(line.info, line.common); }; });
}

void add_distance(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("distance", "Accuracy and completeness of a mesh against a synthetic scene");
  command->add_option("mesh", line.distance.mesh, "The mesh")->required()->type_name("MESH");
  command->add_option("truth", line.distance.truth, "Folder that `synth` wrote")->required()->type_name("DIR");
  command
      ->add_option("--trajectory", line.distance.trajectory,
                   "The run's trajectory.txt, where it has a world of its own")
      ->type_name("FILE");
  add_common(*command, line);
  command->final_callback([&line] { line.command = [&line] { return distance_command(line.distance, line.common); }; });
}

void add_config(CLI::App& app, CommandLine& line) {
  CLI::App* config = app.add_subcommand("config", "Print, check and document the configuration");
  config->require_subcommand(1);
  CLI::App* print = config->add_subcommand("print", "The configuration that `run` would use, as YAML to edit");
  print->add_flag("--defaults", line.config.built_in, "Without the defaults of `run`: what is built in");
  add_common(*print, line);
  print->final_callback([&line] { line.command = [&line] { return config_print_command(line.config, line.common); }; });

  CLI::App* check = config->add_subcommand("check", "Report every error of a file");
  check->add_option("file", line.config.file, "Configuration file")->required()->type_name("FILE");
  add_common(*check, line);
  check->final_callback([&line] { line.command = [&line] { return config_check_command(line.config, line.common); }; });

  CLI::App* schema = config->add_subcommand("schema", "JSON Schema for editors");
  schema->final_callback([&line] { line.command = [] { return config_schema_command(); }; });
  CLI::App* docs = config->add_subcommand("docs", "docs/configuration.md");
  docs->final_callback([&line] { line.command = [] { return config_docs_command(); }; });
}

void add_devices(CLI::App& app, CommandLine& line) {
  const auto add = [&](const char* name, const char* text, int (*command)(const CommonArguments&)) {
    CLI::App* added = app.add_subcommand(name, text);
    add_common(*added, line);
    added->final_callback([&line, command] { line.command = [&line, command] { return command(line.common); }; });
  };
  add("devices", "List the scanners that are plugged in", devices_command);
  add("doctor", "Find what keeps a scanner from working", doctor_command);

  CLI::App* rules = app.add_subcommand("udev-rules", "Print the rules that let you use your scanners");
  rules
      ->add_option("--device", line.rules_device,
                   "Of this camera only, be it known or not: 1234:5678 or usb:1234:5678; "
                   "default: of all that are known")
      ->type_name("VID:PID");
  add_common(*rules, line);
  rules->final_callback(
      [&line] { line.command = [&line] { return udev_rules_command(line.rules_device, line.common); }; });
}

/// What to say after CLI11's own sentence.
std::string hint_for(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2) return "";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return fmt::format("\nSee scanknit {} --help", argv[1]);
    names.push_back(command->get_name());
  }
  const auto near = nearest_word(argv[1], names);
  return near ? fmt::format("\nDid you mean scanknit {}?", *near) : "\nSee scanknit --help";
}

int run_chosen(CommandLine& line) {
  line.common.verbosity = line.is_quiet     ? Verbosity::kQuiet
                          : line.is_verbose ? Verbosity::kVerbose
                                            : Verbosity::kNormal;
  std::unique_ptr<tbb::global_control> limit;
  if (line.threads > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, line.threads);
  }
  try {
    return line.command();
  } catch (const std::bad_alloc&) {
    return fail({ErrorCode::kBudget, "out of memory"}, line.common);
  } catch (const std::exception& exception) {
    return fail({ErrorCode::kInternal, fmt::format("internal error: {}", exception.what())}, line.common);
  }
}

}  // namespace

int run_cli(int argc, const char* const* argv) {
  CommandLine line;
  CLI::App app("ScanKnit: from depth frames to a coloured, correct mesh", "scanknit");
  app.set_version_flag("-V,--version", std::string("scanknit ") + kVersion);
  app.set_help_all_flag("--help-all", "Help of every command");
  app.footer(kExitCodesHelp);
  app.require_subcommand(0, 1);
  add_run(app, line);
  add_capture(app, line);
  add_record(app, line);
  add_view(app, line);
  add_common(
      *add_report_command(app, line.report,
                          [&line] { line.command = [&line] { return report_command(line.report, line.common); }; }),
      line);
  add_extract(app, line);
  add_align(app, line);
  add_synth(app, line);
  add_convert(app, line);
  add_repair(app, line);
  add_info(app, line);
  add_distance(app, line);
  add_devices(app, line);
  add_config(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    fmt::print(stderr, "error: {}{}\n", error.what(), hint_for(app, argc, argv));
    return exit_code_of(ErrorCode::kUsage);
  }
  if (!line.command) {
    fmt::print("{}", app.help());
    return kExitOk;
  }
  return run_chosen(line);
}

}  // namespace scanknit
