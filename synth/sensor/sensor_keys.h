// The keys of a RenderedSensor: every value by name, with its unit and range.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "synth/sensor/rendered_sensor.h"

namespace scanknit {

enum class SensorUnit { kNumber, kShare, kPixels, kMetres, kSeconds, kDegrees, kHertz, kUnitsPerMetre };

/// The unit as it is printed: "px", "m", "s", "deg", "Hz", "per m"; nothing for a number or a share.
[[nodiscard]] std::string_view to_string(SensorUnit unit);

struct SensorKey {
  std::string_view name;  ///< GROUP.VALUE
  SensorUnit unit;
  double lowest, highest;
  double& (*value)(RenderedSensor&);
  std::string_view meaning;
};

/// All keys, group by group.
[[nodiscard]] const std::vector<SensorKey>& sensor_keys();

[[nodiscard]] double value_of(const SensorKey& key, const RenderedSensor& sensor);

/// Changes one value, "disparity.noise=0.1px" or "shutter.depth=0ms", or a whole effect: "edges=off" makes its values
/// those of the ideal sensor, "edges=on" those of the sensor's own name. Both words are also values of a single key.
/// Units: px; mm, cm, m; ms, s; %; deg; Hz; a plain number is in the key's own. Errors (kConfig) name the key, the
/// value, and what was expected.
[[nodiscard]] Result<void> set_sensor_value(RenderedSensor& sensor, std::string_view assignment);

/// Every value within its range, and the limits of a range in order. Errors as above.
[[nodiscard]] Result<void> validate(const RenderedSensor& sensor);

}  // namespace scanknit
