// Fills in what a configuration leaves to the sensor: its range, its noise and its timing.
#pragma once

#include <optional>

#include "acquire/frame_source.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Sets the range, the noise and the timing that `config` leaves to the sensor; `recognised` is that sensor (nothing:
/// unknown). Says which sensor and which range were chosen, in one line each. Afterwards `config` leaves nothing to the
/// sensor: it opens the recording again with the same settings.
void apply_sensor(const std::optional<RecognisedSensor>& recognised, ScanConfig& config, ScanSession& session);

}  // namespace scanknit
