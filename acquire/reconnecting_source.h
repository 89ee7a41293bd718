// A scanner that may be unplugged while it streams, and that continues when it is plugged in again.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>

#include "acquire/device_source.h"

namespace scanknit {

/// Finds and opens the same scanner again; searches until it is there, or until a stop.
using ReopenDevice = std::function<Result<std::unique_ptr<DeviceSource>>(std::stop_token stop)>;

/// Wraps `source`: after DeviceEvent::kLeft it opens the scanner again with `reopen` and starts the same streams
/// (kReturned), or fails when the scanner does not return within `patience` (kFailed). Frame numbers, the camera's time
/// and losses continue.
[[nodiscard]] std::unique_ptr<DeviceSource> make_reconnecting(std::unique_ptr<DeviceSource> source, ReopenDevice reopen,
                                                              std::chrono::milliseconds patience);

}  // namespace scanknit
