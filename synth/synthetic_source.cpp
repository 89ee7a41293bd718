#include "synth/synthetic_source.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/limits.h"

namespace scanknit {

Result<void> validate(const SynthConfig& config) {
  constexpr int kMaxPictures = 1'000'000;  // six digits in a file name
  const auto refuse = [](const char* field, const auto& value, const char* expected) {
    return Error{ErrorCode::kConfig, fmt::format("{}: {}, expected {}", field, value, expected), "synth"};
  };
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
  if (config.min_views < 1) return refuse("min_views", config.min_views, "at least 1");
  return {};
}

SyntheticScanner::SyntheticScanner(const SyntheticScene& scene, const SynthConfig& config)
    : scene_(scene), config_(config), poses_(camera_path(scene, config.frames)) {
  SCANKNIT_CHECK(validate(config).has_value());
  if (!config.turntable) return;
  constexpr int kDefaultFrames = 120;
  const int frames = config.frames > 0 ? config.frames : kDefaultFrames;
  rig_.emplace(scene, *config.turntable, frames, config.seed);
  poses_.clear();
  for (int i = 0; i < frames; ++i) poses_.push_back(rig_->T_object_camera(static_cast<std::size_t>(i)));
}

std::size_t SyntheticScanner::pictures() const {
  return poses_.size() * static_cast<std::size_t>(config_.stills);
}

Shot SyntheticScanner::shoot(std::size_t picture) const {
  SCANKNIT_CHECK(picture < pictures());
  const std::size_t place = picture / static_cast<std::size_t>(config_.stills);
  const Pose& pose = poses_[place];
  Shot shot{pose, rig_ ? rig_->render(config_.intrinsics, place) : render(scene_, config_.intrinsics, pose), {}};
  shot.depth_m = config_.noise ? add_kinect_noise(shot.exact.depth_m, shot.exact.cos_incidence, config_.intrinsics,
                                                  config_.noise_model, config_.seed, picture)
                               : shot.exact.depth_m;
  return shot;
}

Result<std::unique_ptr<SyntheticSource>> SyntheticSource::create(std::unique_ptr<SyntheticScene> scene,
                                                                 const SynthConfig& config) {
  SCANKNIT_CHECK(scene != nullptr);
  if (auto valid = validate(config); !valid) return valid.error();
  return std::unique_ptr<SyntheticSource>(new SyntheticSource(std::move(scene), config));
}

SyntheticSource::SyntheticSource(std::unique_ptr<SyntheticScene> scene, const SynthConfig& config)
    : scene_(std::move(scene)), intrinsics_(config.intrinsics), scanner_(*scene_, config) {
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
  frame.timestamp_ns = static_cast<std::int64_t>(next_);
  frame.depth_m = std::move(shot.depth_m);
  frame.intrinsics = intrinsics_;
  frame.colour = ColourFrame{std::move(shot.exact.colour), intrinsics_};
  frame.T_world_camera = shot.T_world_camera;
  ++next_;
  return frame;
}

}  // namespace scanknit
