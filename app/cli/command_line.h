// The parsed command line: all arguments, and the command to run.
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/calibrate/calibrate_arguments.h"
#include "app/commands.h"

namespace scanknit {

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
  PlanArguments plan;
  WorkArguments work;
  JoinArguments join;
  StatusArguments status;
  ClusterArguments cluster;
  SynthArguments synth;
  ConfigArguments config;
  InfoArguments info;
  ConvertArguments convert;
  RepairArguments repair;
  DistanceArguments distance;
  MeasureArguments measure;
  CalibrateTargetArguments calibrate_target;
  CalibrateCameraArguments calibrate_camera;
  CalibrateRigArguments calibrate_rig;
  CompletionArguments completion;
  ManArguments man;
  std::string rules_device;
  bool is_quiet = false, is_verbose = false;
  std::function<int()> command;

  /// The possible values of an option, or their beginnings ("fusion.voxel_size="). For completion and manual pages.
  std::map<const CLI::Option*, std::vector<std::string>> words;
};

/// Adds every command of the program. `app` and `line` must outlive the parsing and the command.
void add_commands(CLI::App& app, CommandLine& line);

}  // namespace scanknit
