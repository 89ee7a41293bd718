// Every command of the program: its options, and what it calls.
#include "app/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/cli/cli_align.h"
#include "app/cli/cli_calibrate.h"
#include "app/cli/cli_measure.h"
#include "app/cli/cli_options.h"
#include "app/cli/command_tree.h"
#include "app/cli/rig_options.h"
#include "app/cli/sensor_options.h"
#include "app/modules/commands_module.h"
#include "app/modules/recording_commands_module.h"
#include "app/modules/synth_commands_module.h"
#include "core/files/quantity.h"
#include "core/system/module.h"
#include "synth/scene/scene_names.h"

namespace scanknit {
namespace {

/// A command of a module, which is opened when the command runs. `arguments` are parts of `line`.
template <typename Module, typename Command, typename... Arguments>
std::function<int()> from_module(const CommandLine& line, Command Module::*command, const Arguments&... arguments) {
  return [&line, command, &arguments...] {
    const auto module = load_module<Module>(Module::kName, "It comes with ScanKnit: install ScanKnit again");
    if (!module) return fail(module.error(), line.common);
    return ((*module)->*command)(arguments..., line.common);
  };
}

/// True when one object is scanned: the user walks round it, or it turns.
bool is_orbit(const ConfigSources& config) {
  const auto& presets = config.presets;
  return std::any_of(presets.begin(), presets.end(),
                     [](const std::string& name) { return name == "object" || name == "turntable"; });
}

std::string why_not_mcap(const std::string& file) {
  const bool is_mcap = std::filesystem::path(file).extension() == ".mcap";
  return is_mcap ? "" : file + ": no such output: give a file that ends in .mcap";
}

/// Which frames of a recording, for RunArguments and PlanArguments.
template <typename Arguments>
void add_frame_options(CLI::App& command, Arguments& frames) {
  command.add_option("--from", frames.from, "First frame, counting from 0")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command.add_option("--to", frames.to, "Last frame, included")->check(CLI::NonNegativeNumber)->type_name("N");
  command.add_option("--every", frames.every, "Take every N-th frame")->check(CLI::Range(1, 1'000'000))->type_name("N");
}

void add_run(CLI::App& app, CommandLine& line) {
  RunArguments& run = line.run;
  CLI::App* command = app.add_subcommand("run", "Fuse a recording and write the mesh");
  command->add_option("recording", run.recording, "Folder or file of the recording")
      ->required()
      ->type_name("RECORDING");
  command->add_option("beside", run.beside, "With --rig: the recordings of its other cameras")->type_name("RECORDING");
  command->add_option("--rig", run.rig, "Several cameras that stand still, as `calibrate rig` found them")
      ->type_name("RIG.yaml");
  add_output_options(*command, run.outputs);
  add_frame_options(*command, run);
  const OptionText pace = {
      "--pace", "fast; realtime: by the recording's clock; stepped: a frame for each Enter; the mesh is the same"};
  add_choice(*command, line, pace, run.pace,
             {{"fast", Pace::kFast}, {"realtime", Pace::kRealtime}, {"stepped", Pace::kStepped}})
      ->type_name("PACE");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording");
  add_shorthand(*command, line, "--geometry", "acquire.geometry",
                "depth; silhouettes: a visual hull from pictures with masks; stereo: depth from pairs of pictures");
  add_shorthand(*command, line, "--poses", "acquire.poses",
                "Where poses come from: auto, recording, track, refine, still");
  command->add_option("--class", run.mask_class, "Of acquire.masks: one class, or all, each with a mesh of its own")
      ->type_name("all|N");
  add_turntable_options(*command, run);
  add_texture_option(*command, line.common.config);
  add_export_options(*command, line.common.config);
  add_view_options(*command, run.view);
  add_common(*command, line);
  command->final_callback([&line] {
    line.run.view.is_orbit = is_orbit(line.common.config);
    line.command = from_module(line, &CommandsModule::run, line.run);
  });
}

void add_capture(CLI::App& app, CommandLine& line) {
  CaptureArguments& capture = line.capture;
  CLI::App* command = app.add_subcommand("capture", "Scan with a scanner that is plugged in, and write the mesh");
  add_output_options(*command, capture.outputs);
  add_scanner_options(*command, capture.scanner);
  auto* recording = command->add_option("--recording", capture.recording, "Keep the raw pictures here (default: OUT)")
                        ->check(why_not_mcap)
                        ->type_name("FILE.mcap");
  command->add_flag("!--no-recording", capture.wants_recording, "Do not keep the raw pictures")->excludes(recording);
  add_shorthand(*command, line, "--geometry", "acquire.geometry",
                "depth; stereo: depth from the infrared pairs of a RealSense");
  add_shorthand(*command, line, "--poses", "acquire.poses", "track (the default), or still");
  add_texture_option(*command, line.common.config);
  add_export_options(*command, line.common.config);
  add_view_options(*command, capture.view);
  add_common(*command, line);
  command->final_callback([&line] {
    line.capture.view.is_orbit = is_orbit(line.common.config);
    line.command = from_module(line, &CommandsModule::capture, line.capture);
  });
}

void add_view(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("view", "Show a mesh in a browser");
  command->add_option("file", line.show.file, "A mesh (.glb .ply .obj .stl), or the folder that `run` wrote one into")
      ->required()
      ->type_name("FILE|OUT");
  add_server_options(*command, line.show.server, nullptr);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::view, line.show); });
}

void add_report(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("report", "Draw report.html again, from report.json and the files beside it");
  command
      ->add_option("place", line.report.place,
                   "The folder that `run`, `capture`, `extract` or `align` wrote, or a report.json")
      ->required()
      ->type_name("OUT|FILE.json");
  command->add_option("--report", line.report.report, "Where the report of that folder is, default: OUT/report.json")
      ->type_name("FILE");
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::report, line.report); });
}

void add_record(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("record", "Keep what a scanner sends, for `run`");
  command->add_option("-o,--output", line.record.output, "The recording")
      ->required()
      ->check(why_not_mcap)
      ->type_name("FILE.mcap");
  command->add_flag("--ros2", line.record.wants_ros2, "Write a bag of ROS 2: Image, CameraInfo, tf_static");
  add_scanner_options(*command, line.record.scanner);
  add_shorthand(*command, line, "--geometry", "acquire.geometry", "depth; stereo: the infrared pairs of a RealSense");
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::record, line.record); });
}

void add_extract(CLI::App& app, CommandLine& line) {
  ExtractArguments& extract = line.extract;
  CLI::App* command = app.add_subcommand("extract", "Mesh a volume: its isosurface");
  command
      ->add_option("volume", extract.volume,
                   "OpenVDB, NRRD, MetaImage, NIfTI, raw samples, or a folder of DICOM, PNG or TIFF slices")
      ->required()
      ->type_name("VOLUME");
  add_output_options(*command, extract.outputs);
  auto* isovalue = add_shorthand(*command, line, "--isovalue", "extract.isovalue", "Value of the surface");
  command->add_flag("--auto-isovalue", extract.wants_auto_isovalue, "Propose a value from the volume's (Otsu 1979)")
      ->excludes(isovalue);
  command->add_flag("--stats", extract.wants_stats, "Print how often each configuration and sub-case occurred");
  add_shorthand(*command, line, "--decider", "extract.decider", "How ambiguous cells are resolved");
  add_shorthand(*command, line, "--inside", "extract.inside", "Which side is matter: auto, low, high");
  add_volume_options(*command, line, extract.options);
  add_refused_texture_option(*command, line.common.config);
  add_export_options(*command, line.common.config);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::extract, line.extract); });
}

void add_align(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("align", "Bring several scans of one thing together, and write one mesh");
  add_align_options(*command, line.align);
  add_output_options(*command, line.align.outputs);
  add_shorthand(*command, line, "--poses", "acquire.poses", "Where the poses of a recording's own frames come from");
  add_refused_texture_option(*command, line.common.config);
  add_export_options(*command, line.common.config);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::align, line.align); });
}

CLI::App* add_job_command(CLI::App& app, std::filesystem::path& job, const char* name, const char* text) {
  CLI::App* command = app.add_subcommand(name, text);
  command->add_option("job", job, "The folder that `plan` made")->required()->type_name("JOB");
  return command;
}

/// The commands that scan a recording with several processes.
void add_job(CLI::App& app, CommandLine& line) {
  CLI::App* plan = app.add_subcommand("plan", "Prepare a recording to be fused by several processes or machines");
  plan->add_option("recording", line.plan.recording, "Folder or file of the recording")
      ->required()
      ->type_name("RECORDING");
  plan->add_option("-o,--output", line.plan.job, "The job: a new folder, on storage that all workers share")
      ->required()
      ->type_name("JOB");
  add_frame_options(*plan, line.plan);
  add_shorthand(*plan, line, "--format", "acquire.format", "Layout of the recording");
  auto* poses = add_shorthand(*plan, line, "--poses", "acquire.poses",
                              "Where poses come from: auto, recording, track, refine, still");
  plan->add_option("--trajectory", line.plan.trajectory, "The poses of the frames: a file of TUM, .kitti or .json")
      ->excludes(poses)
      ->type_name("FILE");
  auto* estimate = plan->add_flag("--estimate", line.plan.estimates,
                                  "Say what the job will take; fuses and joins some bricks to know");
  plan->add_option("--workers", line.plan.workers, "Of the estimate; 0: they do not know how many they are, default: 1")
      ->check(CLI::Range(0, 1'000'000))
      ->needs(estimate)
      ->type_name("N");
  add_texture_option(*plan, line.common.config);
  add_export_options(*plan, line.common.config);
  add_common(*plan, line);
  plan->final_callback([&line] { line.command = from_module(line, &CommandsModule::plan, line.plan); });

  CLI::App* work = add_job_command(app, line.work.job, "work", "Fuse bricks of a job that no other worker has");
  auto* brick =
      work->add_option("--brick", line.work.brick, "Only this one, counting from 0; checks all of it if it is done")
          ->check(CLI::NonNegativeNumber)
          ->type_name("N");
  auto* workers = work->add_option("--workers", line.work.workers,
                                   "So many share the job: take several bricks at once, which is faster")
                      ->check(CLI::Range(1, 1'000'000))
                      ->excludes(brick)
                      ->type_name("N");
  work->add_option("--local", line.work.local, "Start N processes on this machine, which work until the job is done")
      ->check(CLI::Range(1, 1024))
      ->excludes(brick)
      ->excludes(workers)
      ->type_name("N");
  add_common(*work, line);
  work->final_callback([&line] { line.command = from_module(line, &CommandsModule::work, line.work); });

  CLI::App* join = add_job_command(app, line.join.job, "join", "Write the mesh of a job whose bricks are all done");
  add_output_options(*join, line.join.outputs);
  add_common(*join, line);
  join->final_callback([&line] { line.command = from_module(line, &CommandsModule::join, line.join); });

  CLI::App* status = add_job_command(app, line.status.job, "status", "Say how many bricks of a job are done");
  status->add_flag("--check", line.status.opens_bricks, "Open each brick, to find torn ones");
  add_common(*status, line);
  status->final_callback([&line] { line.command = from_module(line, &CommandsModule::status, line.status); });
}

/// Options of sbatch have their own way of being written: --account=NAME.
void add_slurm_option(CLI::App& command, ClusterArguments& cluster, const char* name, const char* text,
                      const char* type = "NAME") {
  const auto append = [&cluster, name](const std::string& value) {
    cluster.slurm_options.push_back(std::string(name) + "=" + value);
  };
  command.add_option_function<std::string>(name, append, text)->type_name(type);
}

void add_cluster(CLI::App& app, CommandLine& line) {
  ClusterArguments& cluster = line.cluster;
  CLI::App* command =
      app.add_subcommand("cluster", "Plan, fuse and join a scan on a cluster, and follow it to its end");
  command->add_option("job", cluster.job, "The job's folder, on storage that all nodes share")
      ->required()
      ->type_name("JOB");
  command->add_option("plan", cluster.plan, "If JOB is not planned yet: RECORDING and options of plan, after --")
      ->type_name("ARGUMENTS");
  command->add_flag("--slurm", cluster.uses_slurm, "The engine: Slurm")->required();
  command->add_option("-o,--output", cluster.output, "What join writes: a folder, or one file")->type_name("OUT");
  command->add_option("--array-size", cluster.array_size, "Workers, each with --threads threads; default: 8, of one")
      ->check(CLI::Range(1, 100'000))
      ->type_name("N");
  add_slurm_option(*command, cluster, "--account", "Whose account pays");
  add_slurm_option(*command, cluster, "--partition", "Nodes to use");
  add_slurm_option(*command, cluster, "--time", "Limit of each batch, as sbatch reads it", "TIME");
  command
      ->add_option("--sbatch", cluster.slurm_options, "One more option of sbatch, may be repeated: --sbatch=--mem=4G")
      ->allow_extra_args(false)
      ->type_name("OPTION");
  command->add_flag("--cancel", cluster.is_cancelling, "Take the job's batches out of the queue");
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &CommandsModule::cluster, line.cluster); });
}

void add_synth(CLI::App& app, CommandLine& line) {
  SynthArguments& synth = line.synth;
  CLI::App* command = app.add_subcommand("synth", "Scan a scene that is known exactly, for tests and demonstrations");
  auto* scene =
      command->add_option("scene", synth.scene, "Name of a scene (--list), or a closed mesh file")->type_name("SCENE");
  line.words[scene].assign(kSceneNames.begin(), kSceneNames.end());
  auto* output = command->add_option("-o,--output", synth.output, "Folder of the new recording")->type_name("DIR");
  command->add_option("--frames", synth.frames, "Number of frames")->check(CLI::Range(1, 100'000))->type_name("N");
  command->add_option("--width", synth.width, "Width of the pictures, pixels")->check(CLI::Range(16, 4096));
  command->add_option("--height", synth.height, "Height of the pictures, pixels")->check(CLI::Range(16, 4096));
  auto* noise = command->add_flag("--noise", synth.has_noise, "Simple noise like a Kinect's");
  command->add_option("--seed", synth.seed, "Seed of the noise")->check(CLI::NonNegativeNumber)->type_name("N");
  command->add_flag("--jpeg", synth.has_jpeg_colour, "Colour pictures as JPEG, smaller than PNG");
  command->add_flag("--masks", synth.has_masks,
                    "Masks, too: white where there is a surface (acquire.geometry=silhouettes; of a MESH alone)");
  const auto set_size = [&synth](const std::string& text) {
    const auto length = parse_length(text);
    if (!length || length->metres <= 0) throw CLI::ValidationError("--size", "expected a length such as 20cm, 0.2");
    synth.size_m = length->metres;
  };
  command->add_option_function<std::string>("--size", set_size, "Longest side of a mesh: 20cm")->type_name("LENGTH");
  add_sensor_options(*command, line, noise);
  add_rig_options(*command, synth);
  command->add_flag("--list", synth.only_list, "List the scenes, paths, sensors and their values")
      ->excludes(scene)
      ->excludes(output);
  add_common(*command, line);
  command->final_callback([&line] {
    const SynthArguments& given = line.synth;
    if (!given.only_list && given.scene.empty()) throw CLI::RequiredError("SCENE (or --list)");
    if (!given.only_list && given.output.empty()) throw CLI::RequiredError("--output");
    line.command = from_module(line, &SynthCommandsModule::synth, line.synth);
  });
}

void add_convert(CLI::App& app, CommandLine& line) {
  ConvertArguments& convert = line.convert;
  CLI::App* command = app.add_subcommand("convert", "Write a recording in another layout");
  command->add_option("recording", convert.recording, "Folder or file of the recording")
      ->required()
      ->type_name("RECORDING");
  command->add_option("-o,--output", convert.output, "A file .mcap (mcap, ros2), or a new folder")
      ->required()
      ->type_name("OUT");
  add_choice(*command, line, {"--to", "mcap, tum, open3d, 7-scenes, nerfstudio, colmap, fakenect, ros2"},
             convert.target,
             {{"mcap", ConvertTarget::kMcap},
              {"tum", ConvertTarget::kTum},
              {"open3d", ConvertTarget::kOpen3d},
              {"7-scenes", ConvertTarget::kSevenScenes},
              {"nerfstudio", ConvertTarget::kNerfstudio},
              {"colmap", ConvertTarget::kColmap},
              {"fakenect", ConvertTarget::kFakenect},
              {"ros2", ConvertTarget::kRos2}})
      ->required()
      ->type_name("LAYOUT");
  command
      ->add_option("--frames", convert.frames,
                   "nerfstudio, colmap: only N frames, the sharpest of each of N equal parts of the camera's way")
      ->check(CLI::Range(1, 1'000'000))
      ->type_name("N");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording that is read");
  add_common(*command, line);
  command->final_callback([&line] {
    const ConvertTarget target = line.convert.target;
    if (line.convert.frames > 0 && target != ConvertTarget::kNerfstudio && target != ConvertTarget::kColmap) {
      throw CLI::ValidationError("--frames", "only with --to nerfstudio or --to colmap");
    }
    const std::string why = why_not_mcap(line.convert.output.string());
    if (is_one_file(line.convert.target) && !why.empty()) throw CLI::ValidationError("--output", why);
    line.command = from_module(line, &RecordingCommandsModule::convert, line.convert);
  });
}

void add_repair(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("repair", "Mend a recording (.mcap) that was cut short or damaged");
  command->add_option("file", line.repair.file, "The recording")->required()->type_name("FILE.mcap");
  command->add_option("-o,--output", line.repair.output, "Write the mended recording here, not in its place")
      ->check(why_not_mcap)
      ->type_name("OUT.mcap");
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &RecordingCommandsModule::repair, line.repair); });
}

void add_info(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("info", "Describe a recording, a volume or a mesh");
  command->add_option("file", line.info.file, "What to describe")->required()->type_name("FILE");
  add_shorthand(*command, line, "--format", "acquire.format", "Layout of the recording");
  add_volume_options(*command, line, line.info.options);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &RecordingCommandsModule::info, line.info); });
}

void add_distance(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("distance", "Deviations of a mesh from a reference mesh, or from a synthetic scene");
  add_distance_options(*command, line);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &SynthCommandsModule::distance, line.distance); });
}

void add_measure(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("measure", "Box, volume, area, thickness, holes, sections and fits of a mesh");
  add_measure_options(*command, line);
  add_common(*command, line);
  command->final_callback([&line] { line.command = from_module(line, &SynthCommandsModule::measure, line.measure); });
}

void add_calibrate(CLI::App& app, CommandLine& line) {
  CLI::App* calibrate = app.add_subcommand("calibrate", "Measure cameras with a printed board");
  calibrate->require_subcommand(1);
  CLI::App* target = calibrate->add_subcommand("target", "Draw a board in true size, to print");
  add_calibrate_target_options(*target, line);
  add_common(*target, line);
  target->final_callback(
      [&line] { line.command = from_module(line, &SynthCommandsModule::calibrate_target, line.calibrate_target); });

  CLI::App* camera = calibrate->add_subcommand("camera", "Find focal lengths, centre and distortion from its pictures");
  add_calibrate_camera_options(*camera, line.calibrate_camera);
  add_shorthand(*camera, line, "--format", "acquire.format", "Layout of the recording");
  add_common(*camera, line);
  camera->final_callback(
      [&line] { line.command = from_module(line, &SynthCommandsModule::calibrate_camera, line.calibrate_camera); });

  CLI::App* rig =
      calibrate->add_subcommand("rig", "Find where several cameras stand, by a board that moves before them");
  add_calibrate_rig_options(*rig, line.calibrate_rig);
  add_shorthand(*rig, line, "--format", "acquire.format", "Layout of the recordings");
  add_common(*rig, line);
  rig->final_callback(
      [&line] { line.command = from_module(line, &SynthCommandsModule::calibrate_rig, line.calibrate_rig); });
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
  const auto add = [&](const char* name, const char* text, auto command) {
    CLI::App* added = app.add_subcommand(name, text);
    add_common(*added, line);
    added->final_callback([&line, command] { line.command = from_module(line, command); });
  };
  add("devices", "List the scanners that are plugged in", &CommandsModule::devices);
  add("doctor", "Find what keeps a scanner from working", &CommandsModule::doctor);

  CLI::App* rules = app.add_subcommand("udev-rules", "Print the rules that let you use your scanners");
  rules
      ->add_option("--device", line.rules_device,
                   "For this camera only, whether it is known or not: 1234:5678 or usb:1234:5678; "
                   "default: for all that are known")
      ->type_name("VID:PID");
  add_common(*rules, line);
  rules->final_callback([&line] { line.command = from_module(line, &CommandsModule::udev_rules, line.rules_device); });
}

void add_completion(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("completion", "Print a script with which a shell completes this program's command line");
  add_choice(*command, line, {"shell", "bash, zsh, fish"}, line.completion.shell,
             {{"bash", Shell::kBash}, {"zsh", Shell::kZsh}, {"fish", Shell::kFish}})
      ->required()
      ->type_name("SHELL");
  command->final_callback([&app, &line] {
    line.command = [&app, &line] { return completion_command(describe_command(app, line), line.completion); };
  });
}

void add_man(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("man", "Write the manual pages: scanknit.1, and one for each command");
  command->add_option("-o,--output", line.man.output, "Folder of the pages")->required()->type_name("DIR");
  command->final_callback(
      [&app, &line] { line.command = [&app, &line] { return man_command(describe_command(app, line), line.man); }; });
}

}  // namespace

void add_commands(CLI::App& app, CommandLine& line) {
  add_run(app, line);
  add_capture(app, line);
  add_record(app, line);
  add_view(app, line);
  add_report(app, line);
  add_extract(app, line);
  add_align(app, line);
  add_job(app, line);
  add_cluster(app, line);
  add_synth(app, line);
  add_convert(app, line);
  add_repair(app, line);
  add_info(app, line);
  add_distance(app, line);
  add_measure(app, line);
  add_calibrate(app, line);
  add_devices(app, line);
  add_config(app, line);
  add_completion(app, line);
  add_man(app, line);
}

}  // namespace scanknit
