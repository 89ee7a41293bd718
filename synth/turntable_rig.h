// TurntableRig: a scene's object on a turntable, in front of a camera that stands still.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "synth/render.h"
#include "synth/scene/scene.h"

namespace scanknit {

struct RigConfig {
  double turns = 1;            ///< turns in the recording; may be less or more than one
  double angle_noise_rad = 0;  ///< deviation of each frame's angle from a steady turn
  bool is_on_side = false;     ///< the object lies on its side
  bool has_hand = false;       ///< a hand reaches for the object for a tenth of the recording
};

/// The object stands (or lies) on a plain disc that turns. The camera's optical axis is tilted against the rotation
/// axis and does not meet it, and the object is off that axis. A table, a box and a wall behind do not turn. Lengths
/// scale with the object's size. The object frame is that of `object`.
class TurntableRig {
 public:
  /// `object` outlives it. frames >= 1.
  TurntableRig(const SyntheticScene& object, const RigConfig& config, int frames, std::uint64_t seed);

  /// The angle of a steady turn, as an encoder would report it; 0 for the first frame. angle_rad() has the true one.
  [[nodiscard]] double steady_angle_rad(std::size_t frame) const;
  [[nodiscard]] double angle_rad(std::size_t frame) const;

  [[nodiscard]] Pose T_object_camera(std::size_t frame) const;
  /// z is the rotation axis, upwards; the origin is on the disc.
  [[nodiscard]] const Pose& T_table_camera() const { return T_table_camera_; }

  /// The same bits for any number of threads.
  [[nodiscard]] RenderedView render(const CameraIntrinsics& camera, std::size_t frame) const;

 private:
  [[nodiscard]] std::optional<Eigen::Vector3d> fist(std::size_t frame) const;

  const SyntheticScene& object_;
  RigConfig config_;
  int frames_;
  std::uint64_t seed_;
  double reach_m_ = 0;  ///< no part of the object is farther from the axis
  double height_m_ = 0;
  Pose T_table_object_;  ///< at angle 0
  Pose T_table_camera_;
  std::unique_ptr<SyntheticScene> still_;
};

}  // namespace scanknit
