// One function a command: arguments in, exit code out. The arguments are plain values: no room is needed to fill them.
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
#include "app/terminal/console.h"
#include "extract/volume/slice_reader.h"
#include "scan/align/align_request.h"
#include "scan/live/scanner_request.h"
#include "view/live_view.h"

namespace scanknit {

/// What every command understands.
struct CommonArguments {
  ConfigSources config;
  std::size_t threads = 0;  ///< 0: as many as the machine has
  bool is_json = false;
  Verbosity verbosity = Verbosity::kNormal;
};

/// What the command line says of the live view.
struct ViewArguments {
  bool is_wanted = false;
  bool is_orbit = false;  ///< an object that is walked round or turned
  LiveViewOptions server;
};

struct RunArguments {
  std::filesystem::path recording;
  OutputRequest outputs;
  std::size_t from = 0;
  std::optional<std::size_t> to;
  std::size_t every = 1;
  Pace pace = Pace::kFast;
  std::optional<std::filesystem::path> angles, cut_recording;  ///< of a turntable
  ViewArguments view;
};

struct ShowArguments {
  std::filesystem::path file;
  LiveViewOptions server;
};

struct ReportArguments {
  std::filesystem::path place;                  ///< the folder that a run wrote, or its report.json
  std::optional<std::filesystem::path> report;  ///< where the folder's report.json is, if elsewhere
};

struct ConvertArguments {
  std::filesystem::path recording, output;
  ConvertTarget target = ConvertTarget::kMcap;
};

struct RepairArguments {
  std::filesystem::path file, output;  ///< output empty: the file itself
};

struct CaptureArguments {
  ScannerRequest scanner;
  OutputRequest outputs;
  bool wants_recording = true;
  std::optional<std::filesystem::path> recording;  ///< nothing: beside the mesh
  ViewArguments view;
};

struct RecordArguments {
  ScannerRequest scanner;
  std::filesystem::path output;
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

struct InfoArguments {
  std::filesystem::path file;
  VolumeOptions options;
};

struct SynthArguments {
  std::string scene;  ///< a scene's name, or a mesh file
  std::filesystem::path output;
  int frames = 0;  ///< 0: the scene's own number
  int width = 640;
  int height = 480;
  bool has_noise = false;
  bool has_jpeg_colour = false;
  std::uint64_t seed = 1;
  double size_m = 0.2;           ///< of a mesh's longest side
  bool is_on_turntable = false;  ///< the scanner stands still, the scene turns
  double turns = 1;
  double angle_noise_degrees = 0;
  bool is_on_side = false, has_hand = false;
  bool only_list = false;
};

struct DistanceArguments {
  std::filesystem::path mesh, truth;
  std::optional<std::filesystem::path> trajectory;  ///< of the run that made the mesh, in the mesh's world
};

struct ConfigArguments {
  std::filesystem::path file;  ///< of `check`
  bool built_in = false;       ///< of `print`: without the defaults of `run`
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
[[nodiscard]] int synth_command(const SynthArguments& arguments, const CommonArguments& common);
[[nodiscard]] int convert_command(const ConvertArguments& arguments, const CommonArguments& common);
[[nodiscard]] int repair_command(const RepairArguments& arguments, const CommonArguments& common);
[[nodiscard]] int info_command(const InfoArguments& arguments, const CommonArguments& common);
[[nodiscard]] int distance_command(const DistanceArguments& arguments, const CommonArguments& common);
[[nodiscard]] int devices_command(const CommonArguments& common);
[[nodiscard]] int doctor_command(const CommonArguments& common);
/// `device`: empty for all that we know.
[[nodiscard]] int udev_rules_command(const std::string& device, const CommonArguments& common);

// These need none: they are in the program itself.
[[nodiscard]] int config_print_command(const ConfigArguments& arguments, const CommonArguments& common);
[[nodiscard]] int config_check_command(const ConfigArguments& arguments, const CommonArguments& common);
[[nodiscard]] int config_schema_command();
[[nodiscard]] int config_docs_command();
[[nodiscard]] int completion_command(const CommandDescription& program, const CompletionArguments& arguments);
[[nodiscard]] int man_command(const CommandDescription& program, const ManArguments& arguments);

/// Writes a result to stdout. Gives kExitOk, or says that stdout would not take it and gives the exit code of kOutput.
[[nodiscard]] int print_result(std::string_view text, const CommonArguments& common);

/// Says the error on stderr and gives its exit code.
[[nodiscard]] int fail(const Error& error, const CommonArguments& common);

}  // namespace scanknit
