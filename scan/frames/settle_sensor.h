// Fills in what a configuration leaves to the sensor: its range, its noise and its timing.
#pragma once

#include <optional>

#include "acquire/frame_source.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Sets what is not given of the sensor's range, noise and timing, by `recognised` (nothing: unknown), and says in one
/// line each which sensor and which range were chosen. Afterwards nothing of these is left to be chosen: the same
/// configuration opens the recording again with the same settings.
void settle_sensor(const std::optional<RecognisedSensor>& recognised, ScanConfig& config, ScanSession& session);

}  // namespace scanknit
