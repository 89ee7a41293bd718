// The request for a scanner: which one, which pictures, and when to stop.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace scanknit {

/// Which scanner to use, and when to stop.
struct ScannerRequest {
  std::string device = {};  ///< as open_camera() takes it; empty: the first
  int width = 640, height = 480;
  double frames_per_second = 30;
  std::optional<std::size_t> frames = {};  ///< stop after so many depth pictures
  std::optional<double> seconds = {};      ///< stop so long after the first picture
  double wait_s = 0;                       ///< how long to wait for a scanner that is not plugged in yet
  double reconnect_s = 30;                 ///< how long to wait for a scanner that was unplugged
  bool takes_from_others = false;
};

}  // namespace scanknit
