// What an emulated camera sees on a slow walk round the synthetic desk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "acquire/raw_frame.h"
#include "core/camera.h"
#include "core/pose.h"
#include "synth/scene/scene.h"
#include "tests/usb/vcam/vcam.h"

namespace scanknit::test {

constexpr int kPictures = 45;  // of desk_view(): three seconds at 15 a second
constexpr int kSlowPictures = 10;

/// Of the emulated camera's depth pictures.
CameraIntrinsics emulated_intrinsics();

/// As Z16, whole millimetres.
std::vector<std::byte> depth_bytes(const DepthImage& depth_m);

/// Part of a walk, through the emulated camera's optics.
class DeskView {
 public:
  /// `pictures` from the step `first` on, of a walk all round in `steps` steps.
  DeskView(int steps, int pictures, int first = 0);

  [[nodiscard]] const SyntheticScene& scene() const { return *scene_; }
  [[nodiscard]] Pose pose(std::size_t n) const { return poses_[first_ + n]; }
  /// depth_bytes(); the last one stays.
  [[nodiscard]] std::vector<std::byte> picture(std::uint64_t n) const;
  /// What a colour camera at T_colour_depth sees at the same time, as YUYV or JPEG.
  [[nodiscard]] std::vector<std::vector<std::byte>> colour(const CameraIntrinsics& camera, const Pose& T_colour_depth,
                                                           PixelFormat format) const;

 private:
  std::unique_ptr<SyntheticScene> scene_;
  std::vector<Pose> poses_;
  std::size_t first_;
  std::vector<std::vector<std::byte>> pictures_;
};

/// 0.6 degrees a picture. Rendered when first asked for: that should be before a camera's clock runs.
const DeskView& desk_view();

/// So slow that pictures of depth and colour belong together though a busy computer's camera waits for it in one of the
/// two streams: a millimetre a picture.
const DeskView& slow_desk_view();

/// A camera that sees it, without colour.
VcamOptions camera_at(const DeskView& view);

}  // namespace scanknit::test
