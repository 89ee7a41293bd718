// Which scanner a live scan or a recording listens to.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace scanknit {

/// Which scanner, and for how long it is listened to.
struct ScannerRequest {
  std::string device = {};  ///< as open_camera() takes it; empty: the first
  int width = 640, height = 480;
  double frames_per_second = 30;
  std::optional<std::size_t> frames = {};  ///< depth pictures after which it ends
  std::optional<double> seconds = {};      ///< ... or so long after the first
  double wait_s = 0;                       ///< for a scanner that is not plugged in yet
  double reconnect_s = 30;                 ///< for one that was unplugged
  bool takes_from_others = false;
};

}  // namespace scanknit
