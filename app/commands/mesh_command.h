// What run, capture, extract and align have in common: from the command line to a mesh, its report and the exit code.
// The Python module runs the same commands (python/scan.cpp).
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>

#include "app/commands.h"
#include "app/config/config_load.h"
#include "app/config/outputs.h"
#include "scan/scan_config.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// What is particular to one of these commands. The functions are called once each, in this order.
struct MeshCommand {
  std::filesystem::path input;  ///< ScanJob::input
  ConfigSources config;
  OutputRequest outputs;
  ViewArguments view = {};      ///< the default shows none: for commands without a live view
  bool is_capture = false;      ///< the frames come from a scanner: Ctrl-C is their normal end, and no interruption
  bool has_case_table = false;  ///< the summary ends with the frequency of the sub-cases

  /// Changes the configuration, or refuses it.
  std::function<Result<void>(ScanConfig&)> configure = [](ScanConfig&) { return Result<void>(); };
  /// Adds to the job what configuration and outputs do not say.
  std::function<void(ScanJob&)> complete = [](ScanJob&) {};
  std::function<ScanResult(const ScanJob&, const LoadedConfig&, ScanObserver&, const std::stop_token&)> scan = {};
};

/// The command of these arguments, which outlive it.
[[nodiscard]] MeshCommand mesh_command_of(const RunArguments& arguments, const ConfigSources& config);
[[nodiscard]] MeshCommand mesh_command_of(const CaptureArguments& arguments, const ConfigSources& config);
[[nodiscard]] MeshCommand mesh_command_of(const ExtractArguments& arguments, const ConfigSources& config);
[[nodiscard]] MeshCommand mesh_command_of(const AlignArguments& arguments, const ConfigSources& config);

/// Runs the command and returns its exit code. To be called before any other thread is started.
[[nodiscard]] int run_mesh_command(const MeshCommand& command, const CommonArguments& common);

}  // namespace scanknit
