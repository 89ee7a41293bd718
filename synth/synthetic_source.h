// SyntheticSource: frames of a synthetic scene, rendered in memory.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "acquire/frame_source.h"
#include "synth/path/motion.h"
#include "synth/render.h"
#include "synth/scene/scene.h"
#include "synth/sensor/frame_times.h"
#include "synth/synth_config.h"
#include "synth/turntable_rig.h"

namespace scanknit {

/// One frame: what a faultless camera with the same lens and shutter would see, and what the sensor reports.
struct Shot {
  Pose T_world_camera;  ///< at the frame's time stamp, of the middle row; for a scene on a turntable: T_object_camera
  ViewCamera camera;    ///< that took `exact`: earlier than the time stamp if the sensor repeats a picture
  RenderedView exact;   ///< at the time of depth
  DepthImage depth_m;   ///< with the configured noise; without noise equal to exact.depth_m
  ColourImage colour;   ///< the sensor's; without a sensor equal to exact.colour
};

/// Scans a scene along its own path. config is valid.
class SyntheticScanner {
 public:
  SyntheticScanner(const SyntheticScene& scene, const SynthConfig& config);

  /// Null unless config.turntable.
  [[nodiscard]] const TurntableRig* turntable() const { return rig_ ? &*rig_ : nullptr; }

  /// The number of pictures that arrive: poses times stills, without those that the sensor drops.
  [[nodiscard]] std::size_t pictures() const;
  /// When each pose's frame was taken; one without a sensor is taken at its own number.
  [[nodiscard]] const std::vector<FrameTime>& times() const { return times_; }
  /// The time stamp, from 0 on. Stills follow each other within one frame's time.
  [[nodiscard]] std::int64_t timestamp_ns(std::size_t picture) const;
  /// Renders the picture with this number; a pure function of the number.
  [[nodiscard]] Shot shoot(std::size_t picture) const;

 private:
  [[nodiscard]] Pose pose_at(double frame) const;
  [[nodiscard]] ViewCamera camera_at(double frame, double readout_s) const;
  [[nodiscard]] RenderedView see(const ViewCamera& camera, double frame) const;
  [[nodiscard]] DepthImage measured(const RenderedView& exact, std::size_t picture) const;
  [[nodiscard]] ColourImage exposed(const RenderedView& exact, const FrameTime& time, std::size_t picture) const;
  [[nodiscard]] int moments_of_blur(double frame) const;

  const SyntheticScene& scene_;
  SynthConfig config_;
  RenderedSensor sensor_;
  Motion motion_;  ///< null for a turntable
  std::vector<FrameTime> times_;
  std::optional<TurntableRig> rig_;
};

/// Frames with their true poses and colour in the depth camera. The depth is not rounded to the unit of a file.
/// world_up is -y.
class SyntheticSource final : public FrameSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SyntheticSource>> create(std::unique_ptr<SyntheticScene> scene,
                                                                       const SynthConfig& config);

  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;
  [[nodiscard]] const SyntheticScene& scene() const { return *scene_; }

 private:
  SyntheticSource(std::unique_ptr<SyntheticScene> scene, const SynthConfig& config);

  std::unique_ptr<SyntheticScene> scene_;
  bool has_clock_;
  CameraIntrinsics intrinsics_;
  SyntheticScanner scanner_;
  RecordingInfo info_;
  std::size_t next_ = 0;
};

}  // namespace scanknit
