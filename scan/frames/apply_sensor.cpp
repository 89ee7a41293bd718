#include "scan/frames/apply_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquire/sensor/sensor_profile.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

const SensorProfile kUnknownSensor = {};  // its noise is a Kinect's

/// Where depth ends because it is noise; 0: nowhere. At tiny voxels a sensor keeps the range in which its noise is at
/// most twice its floor, because it cannot do better.
double noise_end_m(const FusionConfig& fusion) {
  constexpr double kMostFloors = 2;
  const double most_m = std::max(kMostNoiseVoxels * fusion.voxel_size_m, kMostFloors * fusion.noise.floor_m);
  const double end_m = fusion.noise.reach_m(most_m);
  return std::isfinite(end_m) ? std::floor(end_m * 100) / 100 : 0;
}

void report_sensor(const RecognisedSensor& sensor, ScanSession& session) {
  if (sensor.own_noise) return session.info("noise of depth: that of " + sensor.reason);
  session.info(fmt::format("sensor: {}, because {}; acquire.sensor=none treats it as unknown",
                           find_sensor(sensor.model)->name, sensor.reason));
}

void apply_noise(const SensorProfile& sensor, const std::optional<NoiseModel>& own_noise, ScanConfig& config) {
  NoiseModel& noise = config.fusion.noise;
  noise = config.noise.over(own_noise.value_or(sensor.model == SensorModel::kNone ? noise : sensor.noise));
  config.noise = {noise.floor_m, noise.growth_per_m, noise.from_m};
}

void apply_timing(const FrameTiming& timing, AcquireConfig& acquire) {
  if (!acquire.readout_s) acquire.readout_s = timing.readout_s;
  if (!acquire.colour_later_s) acquire.colour_later_s = timing.colour_later_s;
}

void apply_range(const SensorProfile& sensor, ScanConfig& config, ScanSession& session) {
  AcquireConfig& acquire = config.acquire;
  if (!acquire.min_depth_m) {
    const bool leaves_nothing = acquire.max_depth_m.value_or(0) > 0 && *acquire.max_depth_m <= sensor.min_depth_m;
    acquire.min_depth_m = leaves_nothing ? 0 : sensor.min_depth_m;
  }
  if (acquire.max_depth_m) return;
  const double noise_m = noise_end_m(config.fusion);
  const bool is_noise_first = noise_m > 0 && (sensor.max_depth_m == 0 || noise_m < sensor.max_depth_m);
  const double end_m = is_noise_first ? noise_m : sensor.max_depth_m;
  acquire.max_depth_m = end_m > *acquire.min_depth_m ? end_m : 0;
  if (*acquire.max_depth_m == 0) return;
  const std::string why = is_noise_first ? fmt::format("there the noise exceeds {} voxels of {}", kMostNoiseVoxels,
                                                       format_length(config.fusion.voxel_size_m))
                                         : fmt::format("there the range of {} ends", sensor.name);
  session.info(
      fmt::format("depth beyond {} is left out: {}; acquire.max_depth=... keeps more", format_length(end_m), why));
}

}  // namespace

std::optional<FrameTiming> apply_sensor(const std::optional<RecognisedSensor>& recognised, ScanConfig& config,
                                        ScanSession& session) {
  AcquireConfig& acquire = config.acquire;
  if (!acquire.colour_later_s && acquire.camera) acquire.colour_later_s = acquire.camera->colour_later_s;
  if (!acquire.sensor && recognised) report_sensor(*recognised, session);
  const auto own_noise = !acquire.sensor && recognised ? recognised->own_noise : std::nullopt;
  const bool is_by_depth = !acquire.sensor && recognised && recognised->is_by_depth;
  const bool leaves_timing = !acquire.readout_s && !acquire.colour_later_s;
  if (!acquire.sensor) acquire.sensor = recognised ? recognised->model : SensorModel::kNone;
  const SensorProfile* profile = find_sensor(*acquire.sensor);
  const SensorProfile& sensor = profile != nullptr ? *profile : kUnknownSensor;
  apply_noise(sensor, own_noise, config);
  // Depth that is rendered with a sensor's steps is rarely rendered with its shutter.
  apply_timing(is_by_depth ? FrameTiming{} : sensor.timing, acquire);
  apply_range(sensor, config, session);
  const bool may_have_timing = is_by_depth && leaves_timing && !sensor.timing.is_at_once();
  return may_have_timing ? std::optional(sensor.timing) : std::nullopt;
}

}  // namespace scanknit
