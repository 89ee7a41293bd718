// ScannerSettings: settings of a scanner before it streams. Keys of `acquire:` in YAML.
#pragma once

#include <optional>

namespace scanknit {

/// Values that are not given stay as the camera has them.
struct ScannerSettings {
  std::optional<bool> emitter;        ///< the projector of a pattern, on or off
  std::optional<int> laser_power_mw;  ///< of the projector
  std::optional<int> preset;          ///< by the camera's own numbering
  bool locks_exposure = true;         ///< fix colour exposure and white balance after the first second
};

}  // namespace scanknit
