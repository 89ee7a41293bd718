// Fills in what a configuration leaves to the sensor: its range, its noise and its timing.
#pragma once

#include <optional>

#include "acquire/frame_source.h"
#include "core/frame_timing.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Sets the range, the noise and the timing that `config` leaves to the sensor; `recognised` is that sensor (nothing:
/// unknown). Says which sensor and which range were chosen, in one line each. Afterwards `config` leaves nothing to the
/// sensor: it opens the recording again with the same settings.
///
/// A sensor that was recognised by its depth alone may be simulated, without its shutter: then `config` has no timing,
/// and this returns the timing that the sensor would have (nothing: the timing is certain).
std::optional<FrameTiming> apply_sensor(const std::optional<RecognisedSensor>& recognised, ScanConfig& config,
                                        ScanSession& session);

}  // namespace scanknit
