// RecordingFormat: the layouts of recordings that are read. Apart from AcquireConfig, so that a new layout does not
// compile again all that knows a configuration.
#pragma once

namespace scanknit {

/// How a recording is laid out (docs/recordings.md).
enum class RecordingFormat : int {
  kAuto,  ///< by its content
  kSevenScenes,
  kTum,
  kOpen3d,
  kNerfstudio,
  kPhoneLidar,
  kStrayScanner,
  kArkitscenes,
  kPolycam,
  kRecord3d,
  kReplica,
  kBop,
  kPcd,
  kPclzf,
  kFakenect,
  kMcap,
  kRos2,
  kRos1,
  kRealsenseBag,
  kOni,
  kSens,
  kAzureMkv,
};

}  // namespace scanknit
