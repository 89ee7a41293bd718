// ScannerSettings: what a scanner is told before it streams. Keys of `acquire:` in YAML.
#pragma once

#include <optional>

namespace scanknit {

/// What is not given is left as the camera has it.
struct ScannerSettings {
  std::optional<bool> emitter;        ///< the projector of a pattern, on or off
  std::optional<int> laser_power_mw;  ///< of the projector
  std::optional<int> preset;          ///< by the camera's own numbering
  bool locks_exposure = true;         ///< colour exposure and white balance are held after the first second
};

}  // namespace scanknit
