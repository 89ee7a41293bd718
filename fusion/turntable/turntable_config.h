// TurntableConfig: what is known of a turntable, and how to use it. The keys of `turntable:` in YAML.
#pragma once

namespace scanknit {

struct TurntableConfig {
  bool is_enabled = false;           ///< the scanner stands still and the object turns
  bool cuts = true;                  ///< cut away what does not turn with the object, and the disc
  bool closes_base = true;           ///< a plane closes the object where it stood on the disc
  double rpm = 0;                    ///< turns a minute, steady; 0: not known. Needs frames with times
  double step_degrees = 0;           ///< between two frames, steady; 0: not known
  double angle_sigma_degrees = 0.5;  ///< standard deviation of known angles
};

}  // namespace scanknit
