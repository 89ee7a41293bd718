// One function for each command. It takes the arguments, plain values that need no room, and returns the exit code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/convert/convert_recording.h"
#include "acquire/replay/paced_source.h"
#include "app/config/config_load.h"
#include "app/config/outputs.h"
#include "app/measure/measure_arguments.h"
#include "app/terminal/console.h"
#include "extract/volume/slice_reader.h"
#include "scan/align/align.h"
#include "scan/scan.h"
#include "synth/path/path_names.h"
#include "synth/scene/person_names.h"
#include "view/live_view.h"

namespace scanknit {

/// The arguments that every command has.
struct CommonArguments {
  ConfigSources config;
  std::size_t threads = 0;  ///< 0: as many as the machine has
  bool is_json = false;
  Verbosity verbosity = Verbosity::kNormal;
};

/// The arguments of the live view.
struct ViewArguments {
  bool is_wanted = false;
  bool is_orbit = false;  ///< the scan is of one object: the user walks round it, or it turns
  LiveViewOptions server;
};

struct RunArguments {
  std::filesystem::path recording;
  std::vector<std::filesystem::path> beside;  ///< the recordings of a rig's other cameras
  std::optional<std::filesystem::path> rig;   ///< the file that `calibrate rig` wrote
  OutputRequest outputs;
  std::size_t from = 0;
  std::optional<std::size_t> to;
  std::size_t every = 1;
  Pace pace = Pace::kFast;
  std::optional<std::filesystem::path> angles, cut_recording;  ///< of a turntable
  std::optional<std::string> mask_class;                       ///< "all", or a number: acquire.mask_class
  ViewArguments view;
};

struct ShowArguments {
  std::filesystem::path file;
  LiveViewOptions server;
};

struct ReportArguments {
  std::filesystem::path place;                  ///< the folder that a run wrote, or its report.json
  std::optional<std::filesystem::path> report;  ///< the folder's report.json, if it is elsewhere
};

struct ConvertArguments {
  std::filesystem::path recording, output;
  ConvertTarget target = ConvertTarget::kMcap;
  std::size_t frames = 0;  ///< 0: all
};

struct RepairArguments {
  std::filesystem::path file, output;  ///< output empty: the file itself
};

struct CaptureArguments {
  ScannerRequest scanner;
  OutputRequest outputs;
  bool wants_recording = true;
  std::optional<std::filesystem::path> recording;  ///< nothing: next to the mesh
  ViewArguments view;
};

struct RecordArguments {
  ScannerRequest scanner;
  std::filesystem::path output;
  bool wants_ros2 = false;  ///< messages of ROS 2 instead of our own
};

struct ExtractArguments {
  std::filesystem::path volume;
  OutputRequest outputs{.has_trajectory = false};
  VolumeOptions options;
  bool wants_auto_isovalue = false;
  bool wants_stats = false;
};

struct AlignArguments {
  AlignRequest request;
  OutputRequest outputs;
};

struct PlanArguments {
  std::filesystem::path recording, job;
  std::size_t from = 0;
  std::optional<std::size_t> to;
  std::size_t every = 1;
  std::optional<std::filesystem::path> trajectory;  ///< poses of the frames; nothing: as acquire.poses says
  bool estimates = false;                           ///< say what the job will take
  std::size_t workers = 1;                          ///< of the estimate; 0: unknown
};

struct WorkArguments {
  std::filesystem::path job;
  std::optional<std::size_t> brick;  ///< nothing: all
  std::size_t workers = 0;           ///< that share the job; 0: unknown
  std::size_t local = 0;             ///< processes to start here; 0: none, this process works itself
};

struct JoinArguments {
  std::filesystem::path job;
  OutputRequest outputs;
};

struct StatusArguments {
  std::filesystem::path job;
  bool opens_bricks = false;  ///< find torn ones
};

struct ClusterArguments {
  std::filesystem::path job, output;
  std::vector<std::string> plan;           ///< for scanknit plan: the recording and options; empty: the job is planned
  std::size_t array_size = 8;              ///< workers
  std::vector<std::string> slurm_options;  ///< for sbatch, as given
  bool uses_slurm = false;                 ///< the engine
  bool is_cancelling = false;
};

struct InfoArguments {
  std::filesystem::path file;
  VolumeOptions options;
};

struct SynthArguments {
  std::string scene;  ///< a scene's name, or a mesh file
  std::filesystem::path output;
  int frames = 0;             ///< 0: the scene's default
  int width = 0, height = 0;  ///< 0: the sensor's own, or 640 x 480
  bool has_noise = false;
  std::string sensor;                      ///< empty: none
  std::vector<std::string> sensor_values;  ///< KEY=VALUE
  PathKind path = PathKind::kScene;
  PersonKind person = PersonKind::kNobody;
  std::filesystem::path trajectory;  ///< a recorded path; empty: none
  bool has_jpeg_colour = false;
  bool has_masks = false;
  std::uint64_t seed = 1;
  double size_m = 0.2;           ///< of a mesh's longest side
  bool is_on_turntable = false;  ///< the scanner stands still, the scene turns
  double turns = 1;
  double angle_noise_degrees = 0;
  bool is_on_side = false, has_hand = false;
  bool only_list = false;
};

struct DistanceArguments {
  std::filesystem::path mesh, truth;                ///< truth: a folder that `synth` wrote, or a mesh
  std::optional<std::filesystem::path> trajectory;  ///< trajectory of the run that made the mesh, in the mesh's world
  ComparisonArguments comparison;                   ///< with a mesh
};

struct ConfigArguments {
  std::filesystem::path file;  ///< for `check`
  bool built_in = false;       ///< for `print`: leave out the defaults of `run`
};

enum class Shell { kBash, kZsh, kFish };

struct CompletionArguments {
  Shell shell = Shell::kBash;
};

struct ManArguments {
  std::filesystem::path output;
};

struct CommandDescription;  // app/cli/command_tree.h

// These need the rooms: they are in the module (commands_module.h).
[[nodiscard]] int run_command(const RunArguments& arguments, const CommonArguments& common);
[[nodiscard]] int capture_command(const CaptureArguments& arguments, const CommonArguments& common);
[[nodiscard]] int view_command(const ShowArguments& arguments, const CommonArguments& common);
[[nodiscard]] int report_command(const ReportArguments& arguments, const CommonArguments& common);
[[nodiscard]] int record_command(const RecordArguments& arguments, const CommonArguments& common);
[[nodiscard]] int extract_command(const ExtractArguments& arguments, const CommonArguments& common);
[[nodiscard]] int align_command(const AlignArguments& arguments, const CommonArguments& common);
[[nodiscard]] int plan_command(const PlanArguments& arguments, const CommonArguments& common);
[[nodiscard]] int work_command(const WorkArguments& arguments, const CommonArguments& common);
[[nodiscard]] int join_command(const JoinArguments& arguments, const CommonArguments& common);
[[nodiscard]] int status_command(const StatusArguments& arguments, const CommonArguments& common);
[[nodiscard]] int cluster_command(const ClusterArguments& arguments, const CommonArguments& common);
[[nodiscard]] int synth_command(const SynthArguments& arguments, const CommonArguments& common);
[[nodiscard]] int convert_command(const ConvertArguments& arguments, const CommonArguments& common);
[[nodiscard]] int repair_command(const RepairArguments& arguments, const CommonArguments& common);
[[nodiscard]] int info_command(const InfoArguments& arguments, const CommonArguments& common);
/// What info says of a file or folder that is a mesh, an OpenVDB file or another volume: JSON, its entries in this
/// order. Errors: those of reading it.
[[nodiscard]] Result<std::string> describe_shape(const InfoArguments& arguments, const ScanConfig& config);
[[nodiscard]] int distance_command(const DistanceArguments& arguments, const CommonArguments& common);
[[nodiscard]] int measure_command(const MeasureArguments& arguments, const CommonArguments& common);
[[nodiscard]] int devices_command(const CommonArguments& common);
[[nodiscard]] int doctor_command(const CommonArguments& common);
/// `device`: empty for all known cameras.
[[nodiscard]] int udev_rules_command(const std::string& device, const CommonArguments& common);

// These need none: they are in the program itself.
[[nodiscard]] int config_print_command(const ConfigArguments& arguments, const CommonArguments& common);
[[nodiscard]] int config_check_command(const ConfigArguments& arguments, const CommonArguments& common);
[[nodiscard]] int config_schema_command();
[[nodiscard]] int config_docs_command();
[[nodiscard]] int completion_command(const CommandDescription& program, const CompletionArguments& arguments);
[[nodiscard]] int man_command(const CommandDescription& program, const ManArguments& arguments);

/// Writes a result to stdout. Returns kExitOk; if stdout cannot be written, reports that and returns the exit code of
/// kOutput.
[[nodiscard]] int print_result(std::string_view text, const CommonArguments& common);

/// Writes the error to stderr and returns its exit code.
[[nodiscard]] int fail(const Error& error, const CommonArguments& common);

}  // namespace scanknit
