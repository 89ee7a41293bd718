// SyntheticSource: frames of a synthetic scene, rendered in memory.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "acquire/frame_source.h"
#include "synth/render.h"
#include "synth/scene/scene.h"
#include "synth/synth_config.h"
#include "synth/turntable_rig.h"

namespace scanknit {

/// One picture: the ideal camera's view, and the sensor's depth.
struct Shot {
  Pose T_world_camera;  ///< for a scene on a turntable: T_object_camera
  RenderedView exact;
  DepthImage depth_m;  ///< with the configured noise; without noise equal to exact.depth_m
};

/// Scans a scene along its own path. config is valid.
class SyntheticScanner {
 public:
  SyntheticScanner(const SyntheticScene& scene, const SynthConfig& config);

  /// Null unless config.turntable.
  [[nodiscard]] const TurntableRig* turntable() const { return rig_ ? &*rig_ : nullptr; }

  /// The number of pictures: poses times stills.
  [[nodiscard]] std::size_t pictures() const;
  /// Renders the picture with this number; a pure function of the number.
  [[nodiscard]] Shot shoot(std::size_t picture) const;

 private:
  const SyntheticScene& scene_;
  SynthConfig config_;
  std::vector<Pose> poses_;
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
  CameraIntrinsics intrinsics_;
  SyntheticScanner scanner_;
  RecordingInfo info_;
  std::size_t next_ = 0;
};

}  // namespace scanknit
