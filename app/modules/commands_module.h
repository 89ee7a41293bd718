// What libscanknit_commands.so gives: the commands that need the rooms of a scan, and so the libraries that these
// bring.
#pragma once

#include <string>

#include "app/commands.h"
#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

/// Each is the function of that name in commands.h, with no more threads than CommonArguments::threads.
struct CommandsModule {
  static constexpr const char* kName = "commands";

  int (*run)(const RunArguments&, const CommonArguments&);
  int (*capture)(const CaptureArguments&, const CommonArguments&);
  int (*view)(const ShowArguments&, const CommonArguments&);
  int (*report)(const ReportArguments&, const CommonArguments&);
  int (*record)(const RecordArguments&, const CommonArguments&);
  int (*extract)(const ExtractArguments&, const CommonArguments&);
  int (*align)(const AlignArguments&, const CommonArguments&);
  int (*plan)(const PlanArguments&, const CommonArguments&);
  int (*work)(const WorkArguments&, const CommonArguments&);
  int (*join)(const JoinArguments&, const CommonArguments&);
  int (*status)(const StatusArguments&, const CommonArguments&);
  int (*cluster)(const ClusterArguments&, const CommonArguments&);
  int (*devices)(const CommonArguments&);
  int (*doctor)(const CommonArguments&);
  int (*udev_rules)(const std::string&, const CommonArguments&);

  Result<std::string> (*describe_shape)(const InfoArguments&, const ScanConfig&);  ///< for info
};

}  // namespace scanknit
