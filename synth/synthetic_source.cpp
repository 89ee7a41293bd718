#include "synth/synthetic_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/limits.h"
#include "synth/scene/person.h"
#include "synth/sensor/sense_colour.h"
#include "synth/sensor/sense_depth.h"
#include "synth/sensor/sensor_keys.h"

namespace scanknit {

namespace {

template <typename Value>
Error refuse(const char* field, const Value& value, const char* expected) {
  return {ErrorCode::kConfig, fmt::format("{}: {}, expected {}", field, value, expected), "synth"};
}

/// What the scanner is and how it moves.
Result<void> validate_scanner(const SynthConfig& config) {
  if (config.sensor && config.noise) return refuse("noise", "true", "false where there is a sensor");
  if (config.turntable && (config.path != PathKind::kScene || !config.recorded_path.empty())) {
    return refuse("path", kPathNames[static_cast<std::size_t>(config.path)], "none for a scene on a turntable");
  }
  if (config.turntable && config.person != PersonKind::kNobody) {
    return refuse("person", kPersonNames[static_cast<std::size_t>(config.person)], "nobody beside a turntable");
  }
  if (config.recorded_path.size() == 1) return refuse("recorded_path", 1, "at least two poses");
  if (config.sensor) {
    if (auto valid = validate(*config.sensor); !valid) return valid;
  }
  return {};
}

int poses_of(const SynthConfig& config, const SyntheticScene& scene) {
  constexpr int kDefaultTurntableFrames = 120;
  constexpr int kDefaultHandFrames = 480;  // 16 s: some scenes' own paths would whirl a hand round
  if (config.frames > 0) return config.frames;
  if (config.turntable) return kDefaultTurntableFrames;
  if (!config.recorded_path.empty()) {
    const double rate_hz = config.sensor.value_or(RenderedSensor{}).time.rate_hz;
    return 1 + static_cast<int>(std::min(100'000.0, config.recorded_path.back().time_s * rate_hz));
  }
  return config.path == PathKind::kScene ? scene.default_frames()
                                         : std::max(scene.default_frames(), kDefaultHandFrames);
}

}  // namespace

Result<void> validate(const SynthConfig& config) {
  constexpr int kMaxPictures = 1'000'000;  // six digits in a file name
  const CameraIntrinsics& camera = config.intrinsics;
  if (!camera.is_valid() || camera.fx <= 0 || camera.fy <= 0) {
    return refuse("intrinsics", fmt::format("{}x{} fx {} fy {}", camera.width, camera.height, camera.fx, camera.fy),
                  "a size of at least 1x1 and positive focal lengths");
  }
  const std::int64_t pixels = std::int64_t{camera.width} * camera.height;
  if (pixels > Limits{}.max_image_pixels) return refuse("width x height", pixels, "at most 64,000,000 pixels");
  if (config.frames < 0 || config.frames > kMaxPictures) return refuse("frames", config.frames, "0 to 1,000,000");
  if (config.stills < 1 || config.stills > 1000) return refuse("stills", config.stills, "1 to 1000");
  if (std::int64_t{config.frames} * config.stills > kMaxPictures) {
    return refuse("frames x stills", std::int64_t{config.frames} * config.stills, "at most 1,000,000");
  }
  if (!(config.depth_scale >= 1 && config.depth_scale <= 1e6)) {
    return refuse("depth_scale", config.depth_scale, "1 to 1,000,000 units per metre");
  }
  if (config.truth_points > 50'000'000) return refuse("truth_points", config.truth_points, "at most 50,000,000");
  if (config.turntable && !(config.turntable->turns > 0 && config.turntable->turns <= 100)) {
    return refuse("turns", config.turntable->turns, "above 0, at most 100");
  }
  if (config.turntable && !(config.turntable->angle_noise_rad >= 0 && config.turntable->angle_noise_rad <= 0.2)) {
    return refuse("angle noise", config.turntable->angle_noise_rad, "0 to 0.2 radians (11 degrees)");
  }
  if (auto valid = validate_scanner(config); !valid) return valid;
  if (config.min_views < 1) return refuse("min_views", config.min_views, "at least 1");
  return {};
}

CameraIntrinsics stated_camera(const SynthConfig& config) {
  return config.sensor ? stated_camera(*config.sensor, config.intrinsics) : config.intrinsics;
}

double units_per_metre(const SynthConfig& config) {
  return config.sensor ? config.sensor->units_per_metre : config.depth_scale;
}

SyntheticScanner::SyntheticScanner(const SyntheticScene& scene, const SynthConfig& config)
    : scene_(scene), config_(config), sensor_(config.sensor.value_or(RenderedSensor{})) {
  SCANKNIT_CHECK(validate(config).has_value());
  const int frames = poses_of(config, scene);
  times_ = frame_times(sensor_, frames, config.seed);
  const double rate_hz = sensor_.time.rate_hz;
  if (config.turntable) {
    rig_.emplace(scene, *config.turntable, frames, config.seed);
  } else if (!config.recorded_path.empty()) {
    motion_ = fly_again(config.recorded_path, scene.path()(0), rate_hz);
  } else {
    motion_ = make_motion(scene.path(), {config.path, frames, rate_hz, config.seed});
  }
}

std::size_t SyntheticScanner::pictures() const {
  return times_.size() * static_cast<std::size_t>(config_.stills);
}

std::int64_t SyntheticScanner::timestamp_ns(std::size_t picture) const {
  const auto stills = static_cast<std::size_t>(config_.stills);
  const double frame = static_cast<double>(times_[picture / stills].stamp) +
                       static_cast<double>(picture % stills) / static_cast<double>(stills);
  return std::llround(1e9 * frame / sensor_.time.rate_hz);
}

Pose SyntheticScanner::pose_at(double frame) const {
  return rig_ ? rig_->T_object_camera(static_cast<std::size_t>(frame)) : motion_(frame);
}

/// Bands of 12 rows keep the error of a pose below 2 % of what the shutter adds from top to bottom.
ViewCamera SyntheticScanner::camera_at(double frame, double readout_s) const {
  constexpr int kRowsPerBand = 12;
  if (rig_) return {config_.intrinsics, pose_at(frame)};
  const int bands = readout_s > 0 ? std::max(1, config_.intrinsics.height / kRowsPerBand) : 1;
  std::vector<Pose> poses;
  for (int band = 0; band < bands; ++band) {
    const double share = (band + 0.5) / bands - 0.5;  // of the readout, 0 in the picture's middle
    poses.push_back(pose_at(frame + share * readout_s * sensor_.time.rate_hz));
  }
  return {config_.intrinsics, sensor_.lens, std::move(poses)};
}

RenderedView SyntheticScanner::see(const ViewCamera& camera, double frame) const {
  if (rig_) return rig_->render(config_.intrinsics, static_cast<std::size_t>(frame));
  RenderedView view = render(scene_, camera);
  if (const auto person = person_at(config_.person, scene_.name(), frame / sensor_.time.rate_hz)) {
    put_in_front(render(*person, camera), view);
  }
  return view;
}

DepthImage SyntheticScanner::measured(const RenderedView& exact, std::size_t picture) const {
  if (config_.noise) {
    return add_kinect_noise(exact.depth_m, exact.cos_incidence, config_.intrinsics, config_.noise_model, config_.seed,
                            picture);
  }
  return config_.sensor ? sense_depth(exact, config_.intrinsics, sensor_, config_.seed, picture) : exact.depth_m;
}

/// So many that the picture moves by some two pixels between two of them; one if it hardly moves.
int SyntheticScanner::moments_of_blur(double frame) const {
  constexpr int kMost = 4;
  const double half = sensor_.colour.exposure_s * sensor_.time.rate_hz / 2;
  if (!(half > 0)) return 1;
  const Pose moved = motion_(frame - half).inverse() * motion_(frame + half);
  constexpr double kUsualDepth_m = 1.5;
  constexpr double kApart_px = 2;
  const double moved_rad = Eigen::AngleAxisd(moved.linear()).angle() + moved.translation().norm() / kUsualDepth_m;
  return std::clamp(static_cast<int>(std::ceil(config_.intrinsics.fx * moved_rad / kApart_px + 0.5)), 1, kMost);
}

ColourImage SyntheticScanner::exposed(const RenderedView& exact, const FrameTime& time, std::size_t picture) const {
  if (!config_.sensor) return exact.colour;
  const int moments = rig_ ? 1 : moments_of_blur(time.colour_frame);
  const bool is_with_depth = time.colour_frame == static_cast<double>(time.taken) &&
                             sensor_.shutter.colour_s == sensor_.shutter.depth_s && moments == 1;
  if (rig_ || is_with_depth) return sense_colour(exact.colour, sensor_.colour, config_.seed, picture);
  std::vector<ColourImage> pictures;
  for (int i = 0; i < moments; ++i) {
    const double share = (i + 0.5) / moments - 0.5;  // of the exposure
    const double frame = time.colour_frame + share * sensor_.colour.exposure_s * sensor_.time.rate_hz;
    pictures.push_back(see(camera_at(frame, sensor_.shutter.colour_s), frame).colour);
  }
  return sense_colour(blurred(pictures), sensor_.colour, config_.seed, picture);
}

Shot SyntheticScanner::shoot(std::size_t picture) const {
  SCANKNIT_CHECK(picture < pictures());
  const auto stills = static_cast<std::size_t>(config_.stills);
  const FrameTime& time = times_[picture / stills];
  const auto taken = static_cast<double>(time.taken);
  const std::size_t number = time.taken * stills + picture % stills;  // of the random numbers
  const ViewCamera camera = camera_at(taken, sensor_.shutter.depth_s);
  Shot shot{pose_at(static_cast<double>(time.stamp)), camera, see(camera, taken), {}, {}};
  shot.depth_m = measured(shot.exact, number);
  shot.colour = exposed(shot.exact, time, number);
  return shot;
}

Result<std::unique_ptr<SyntheticSource>> SyntheticSource::create(std::unique_ptr<SyntheticScene> scene,
                                                                 const SynthConfig& config) {
  SCANKNIT_CHECK(scene != nullptr);
  if (auto valid = validate(config); !valid) return valid.error();
  return std::unique_ptr<SyntheticSource>(new SyntheticSource(std::move(scene), config));
}

SyntheticSource::SyntheticSource(std::unique_ptr<SyntheticScene> scene, const SynthConfig& config)
    : scene_(std::move(scene)),
      has_clock_(config.sensor.has_value()),
      intrinsics_(stated_camera(config)),
      scanner_(*scene_, config) {
  info_.format = "synthetic";
  info_.frames = info_.frames_with_pose = scanner_.pictures();
  info_.has_colour = true;
  info_.intrinsics = info_.colour_intrinsics = intrinsics_;
  info_.world_up = UpAxis::kMinusY;
}

FrameEvent SyntheticSource::next(std::stop_token stop) {
  if (stop.stop_requested() || next_ >= scanner_.pictures()) return EndOfStream{};
  Shot shot = scanner_.shoot(next_);
  Frame frame;
  frame.sequence = next_;
  frame.has_clock = has_clock_;
  frame.timestamp_ns = has_clock_ ? scanner_.timestamp_ns(next_) : static_cast<std::int64_t>(next_);
  frame.depth_m = std::move(shot.depth_m);
  frame.intrinsics = intrinsics_;
  frame.colour = ColourFrame{std::move(shot.colour), intrinsics_};
  frame.T_world_camera = shot.T_world_camera;
  ++next_;
  return frame;
}

}  // namespace scanknit
