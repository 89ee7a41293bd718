// A scanner for `capture` and `record`: found, opened, and what it shall send chosen.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stop_token>
#include <string>

#include "acquire/live/live_source.h"
#include "app/config/config.h"
#include "app/terminal/console.h"
#include "core/result.h"

namespace scanknit {

/// What the command line says of the scanner and of how long it is listened to.
struct ScannerArguments {
  std::string device;  ///< as open_camera() takes it; empty: the first
  int width = 640, height = 480;
  double frames_per_second = 30;
  std::optional<std::size_t> frames;
  std::optional<double> seconds;
  double wait_s = 0;
  double reconnect_s = 30;
  bool takes_from_others = false;
};

/// Takes what a person is warned of.
using Warn = std::function<void(const std::string&)>;

/// Whether the depth camera must be known.
enum class Calibration { kNeeded, kWelcome };

/// Errors: kUsage, kDevice (absent, forbidden, in use; without a known calibration when that is needed).
/// A setting that the camera does not have is warned of, no more.
[[nodiscard]] Result<LiveScanner> open_scanner(const ScannerArguments& arguments, const Config& config,
                                               Calibration need, std::stop_token stop, Console& console,
                                               const Warn& warn);

/// Its limits; of what happens to the scanner is warned.
[[nodiscard]] LiveOptions live_options(const ScannerArguments& arguments, PoseMode poses, const Warn& warn);

/// By their names in the report.
[[nodiscard]] std::map<std::string, std::uint64_t> named(const LossCounters& losses);

/// Says on the console what was lost, if anything was.
void warn_of_losses(const LossCounters& losses, Console& console);

}  // namespace scanknit
