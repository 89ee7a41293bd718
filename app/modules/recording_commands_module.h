// What libscanknit_recording_commands.so gives: the commands that read recordings and make no mesh. They load no
// OpenVDB, the largest library of a scan.
#pragma once

#include "app/commands.h"

namespace scanknit {

/// Each is the function of that name in commands.h, with no more threads than CommonArguments::threads.
struct RecordingCommandsModule {
  static constexpr const char* kName = "recording_commands";

  int (*convert)(const ConvertArguments&, const CommonArguments&);
  int (*repair)(const RepairArguments&, const CommonArguments&);
  int (*info)(const InfoArguments&, const CommonArguments&);
};

}  // namespace scanknit
