// A scanner that may be unplugged while it streams, and goes on when it is plugged in again.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>

#include "acquire/device_source.h"

namespace scanknit {

/// Finds and opens the same scanner again; looks for it until it is there, or until a stop.
using ReopenDevice = std::function<Result<std::unique_ptr<DeviceSource>>(std::stop_token stop)>;

/// `source`, which after DeviceEvent::kLeft is opened again by `reopen` and started with the same streams (kReturned),
/// or has failed when it did not come back within `patience` (kFailed). Frame numbers, the camera's time and losses go
/// on.
[[nodiscard]] std::unique_ptr<DeviceSource> make_reconnecting(std::unique_ptr<DeviceSource> source, ReopenDevice reopen,
                                                              std::chrono::milliseconds patience);

}  // namespace scanknit
