#include "synth/sensor/sensor_keys.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <utility>

#include "core/files/quantity.h"

namespace scanknit {
namespace {

using enum SensorUnit;

// clang-format off
#define SCANKNIT_PLACE(member) [](RenderedSensor& sensor) -> double& { return sensor.member; }
const std::vector<SensorKey> kKeys = {
    {"disparity.baseline", kMetres, 0, 1, SCANKNIT_PLACE(disparity.baseline_m), "between the two centres; 0: depth is not made of disparity"},
    {"disparity.focal", kPixels, 0, 10'000, SCANKNIT_PLACE(disparity.focal_px), "focal length that disparity is measured with"},
    {"disparity.noise", kPixels, 0, 5, SCANKNIT_PLACE(disparity.noise_px), "standard deviation"},
    {"disparity.step", kPixels, 0, 2, SCANKNIT_PLACE(disparity.step_px), "smallest step; 0: none"},
    {"disparity.window", kPixels, 1, 64, SCANKNIT_PLACE(disparity.window_px), "side of the matching window: noise is correlated over it"},
    {"ranging.floor", kMetres, 0, 0.1, SCANKNIT_PLACE(ranging.floor_m), "noise that no distance changes"},
    {"ranging.share", kShare, 0, 0.2, SCANKNIT_PLACE(ranging.share), "noise as a share of depth"},
    {"range.min", kMetres, 0, 100, SCANKNIT_PLACE(range.min_m), "nothing nearer is seen"},
    {"range.max", kMetres, 0, 100, SCANKNIT_PLACE(range.max_m), "nothing farther is seen"},
    {"shadow.right", kMetres, 0, 1, SCANKNIT_PLACE(shadow.right_m), "to the projector or second camera, at the right; 0: no shadows at the left of objects"},
    {"shadow.left", kMetres, 0, 1, SCANKNIT_PLACE(shadow.left_m), "to the camera that measures, where the picture is another's; 0: none at the right"},
    {"edges.reach", kPixels, 0, 4, SCANKNIT_PLACE(edges.reach_px), "how far from a depth step the other edge effects reach"},
    {"edges.dropout", kShare, 0, 1, SCANKNIT_PLACE(edges.dropout), "of pixels beside a step without depth"},
    {"edges.flying", kShare, 0, 1, SCANKNIT_PLACE(edges.flying), "of pixels beside a step with a depth between both sides"},
    {"edges.lateral", kPixels, 0, 5, SCANKNIT_PLACE(edges.lateral_px), "standard deviation of the place of an edge"},
    {"returns.reach", kMetres, 0, 1000, SCANKNIT_PLACE(returns.reach_m), "where a white surface is just seen; 0: everywhere"},
    {"returns.dark", kShare, 0, 1, SCANKNIT_PLACE(returns.dark), "nothing comes back from surfaces that reflect less"},
    {"returns.gloss", kShare, 0, 1, SCANKNIT_PLACE(returns.gloss), "of its light that a mirror does not send back"},
    {"returns.patches", kNumber, 0, 3, SCANKNIT_PLACE(returns.patches), "deviation of the returned light's logarithm, in patches"},
    {"returns.grazing_begin", kDegrees, 0, 90, SCANKNIT_PLACE(returns.grazing_begin_deg), "angle of incidence at which dropouts begin"},
    {"returns.grazing_end", kDegrees, 0, 90, SCANKNIT_PLACE(returns.grazing_end_deg), "angle at which nothing is left"},
    {"corners.share", kShare, 0, 1, SCANKNIT_PLACE(corners.share), "of a concave corner's depth that light takes which bounced twice"},
    {"corners.radius", kMetres, 0, 1, SCANKNIT_PLACE(corners.radius_m), "how far from a corner its light bounces"},
    {"bias.share", kShare, 0, 0.2, SCANKNIT_PLACE(bias.share), "largest systematic error at 4 m; grows as depth does"},
    {"bias.cells", kNumber, 1, 32, SCANKNIT_PLACE(bias.cells), "waves of that error across the picture"},
    {"camera.focal", kShare, -0.2, 0.2, SCANKNIT_PLACE(calibration.focal_share), "error of the stated focal length"},
    {"camera.centre_x", kPixels, -100, 100, SCANKNIT_PLACE(calibration.centre_x_px), "error of the stated centre, to the right"},
    {"camera.centre_y", kPixels, -100, 100, SCANKNIT_PLACE(calibration.centre_y_px), "error of the stated centre, down"},
    {"lens.k1", kNumber, -0.3, 0.3, SCANKNIT_PLACE(lens.k1), "distortion that the stated camera does not tell of, r^2"},
    {"lens.k2", kNumber, -0.3, 0.3, SCANKNIT_PLACE(lens.k2), "the same, r^4"},
    {"time.rate", kHertz, 1, 240, SCANKNIT_PLACE(time.rate_hz), "pictures a second"},
    {"time.dropped", kShare, 0, 0.9, SCANKNIT_PLACE(time.dropped), "of frames that are missing"},
    {"time.repeated", kShare, 0, 0.9, SCANKNIT_PLACE(time.repeated), "of frames that show the pictures of the one before"},
    {"shutter.depth", kSeconds, 0, 0.2, SCANKNIT_PLACE(shutter.depth_s), "from the first row of a depth picture to the last"},
    {"shutter.colour", kSeconds, 0, 0.2, SCANKNIT_PLACE(shutter.colour_s), "from the first row of a colour picture to the last"},
    {"colour.delay", kSeconds, 0, 0.2, SCANKNIT_PLACE(colour.delay_s), "how much later than depth colour is taken"},
    {"colour.jitter", kSeconds, 0, 0.2, SCANKNIT_PLACE(colour.jitter_s), "later still by a random time up to this"},
    {"colour.exposure", kSeconds, 0, 0.2, SCANKNIT_PLACE(colour.exposure_s), "of each row: motion blur"},
    {"colour.adaptation", kShare, 0, 1, SCANKNIT_PLACE(colour.adaptation), "how far exposure and gain even out the brightness; 1: wholly"},
    {"colour.white_balance", kShare, 0, 1, SCANKNIT_PLACE(colour.white_balance), "how far each picture is made grey on average"},
    {"colour.noise", kShare, 0, 0.5, SCANKNIT_PLACE(colour.noise), "standard deviation, of full scale, at gain 1"},
    {"depth.units", kUnitsPerMetre, 1, 1'000'000, SCANKNIT_PLACE(units_per_metre), "of the depth pictures, which hold 65534 of them"},
};
#undef SCANKNIT_PLACE
// clang-format on

struct Suffix {
  std::string_view text;
  SensorUnit unit;
  double factor;
};
constexpr std::array<Suffix, 9> kSuffixes = {{{"%", kShare, 0.01},
                                              {"px", kPixels, 1},
                                              {"mm", kMetres, 1e-3},
                                              {"cm", kMetres, 1e-2},
                                              {"ms", kSeconds, 1e-3},
                                              {"deg", kDegrees, 1},
                                              {"Hz", kHertz, 1},
                                              {"m", kMetres, 1},
                                              {"s", kSeconds, 1}}};

std::optional<double> parse_value(std::string_view text, SensorUnit unit) {
  for (const Suffix& suffix : kSuffixes) {
    if (suffix.unit != unit || !text.ends_with(suffix.text)) continue;
    const auto number = parse_finite(text.substr(0, text.size() - suffix.text.size()));
    return number ? std::optional(*number * suffix.factor) : std::nullopt;
  }
  return parse_finite(text);
}

std::string expected_text(const SensorKey& key) {
  const std::string unit(to_string(key.unit));
  return fmt::format("expected {} to {}{}{}, on or off", key.lowest, key.highest, unit.empty() ? "" : " ", unit);
}

Error refuse(std::string_view key, std::string_view value, const std::string& expected) {
  return {ErrorCode::kConfig, fmt::format("{}: '{}', {}", key, value, expected), "sensor"};
}

std::string known_keys() {
  std::string known;
  for (const SensorKey& key : kKeys) known += (known.empty() ? "" : ", ") + std::string(key.name);
  return known;
}

/// The sensor that "on" and "off" take values from.
Result<RenderedSensor> reference(const RenderedSensor& sensor, bool is_on) {
  return is_on ? make_sensor(sensor.name) : RenderedSensor{};
}

Result<void> set_key(RenderedSensor& sensor, const SensorKey& key, std::string_view value) {
  if (value == "on" || value == "off") {
    const auto from = reference(sensor, value == "on");
    if (!from) return from.error();
    key.value(sensor) = value_of(key, *from);
    return {};
  }
  const auto number = parse_value(value, key.unit);
  if (!number || !(*number >= key.lowest && *number <= key.highest)) {
    return refuse(key.name, value, expected_text(key));
  }
  key.value(sensor) = *number;
  return {};
}

}  // namespace

std::string_view to_string(SensorUnit unit) {
  switch (unit) {
    case kNumber:
    case kShare: return "";
    case kPixels: return "px";
    case kMetres: return "m";
    case kSeconds: return "s";
    case kDegrees: return "deg";
    case kHertz: return "Hz";
    case kUnitsPerMetre: return "per m";
  }
  return "";
}

const std::vector<SensorKey>& sensor_keys() {
  return kKeys;
}

double value_of(const SensorKey& key, const RenderedSensor& sensor) {
  RenderedSensor copy = sensor;
  return key.value(copy);
}

Result<void> set_sensor_value(RenderedSensor& sensor, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string_view name = assignment.substr(0, equals);
  if (equals == std::string_view::npos) return refuse(name, "", "expected KEY=VALUE");
  const std::string_view value = assignment.substr(equals + 1);
  bool is_group = false;
  for (const SensorKey& key : kKeys) {
    if (key.name == name) return set_key(sensor, key, value);
    if (key.name.substr(0, key.name.find('.')) != name) continue;
    is_group = true;
    if (value != "on" && value != "off") return refuse(name, value, "expected on or off for a whole effect");
    if (auto done = set_key(sensor, key, value); !done) return done;
  }
  if (!is_group) return refuse(name, value, "no such key; there are: " + known_keys());
  return {};
}

Result<void> validate(const RenderedSensor& sensor) {
  for (const SensorKey& key : kKeys) {
    const double value = value_of(key, sensor);
    if (!(value >= key.lowest && value <= key.highest)) {
      return refuse(key.name, fmt::format("{}", value), expected_text(key));
    }
  }
  if (sensor.range.min_m >= sensor.range.max_m) {
    return refuse("range.min", fmt::format("{}", sensor.range.min_m),
                  fmt::format("expected less than range.max, {} m", sensor.range.max_m));
  }
  if (sensor.disparity.baseline_m > 0 && !(sensor.disparity.focal_px > 0)) {
    return refuse("disparity.focal", "0", "expected above 0 where there is a baseline");
  }
  if (sensor.returns.grazing_begin_deg > sensor.returns.grazing_end_deg) {
    return refuse("returns.grazing_begin", fmt::format("{}", sensor.returns.grazing_begin_deg),
                  fmt::format("expected at most returns.grazing_end, {} deg", sensor.returns.grazing_end_deg));
  }
  return {};
}

}  // namespace scanknit
