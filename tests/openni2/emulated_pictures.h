// What the emulated OpenNI2 camera sees: a walk round the synthetic desk, as its driver sends it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "synth/synthetic_source.h"

namespace scanknit::test {

/// So many, forth and back again and again.
inline constexpr std::size_t kEmulatedPictures = 16;
inline constexpr CameraIntrinsics kEmulatedCamera{320, 240, 285, 285, 159.5, 119.5};

struct EmulatedPicture {
  std::vector<std::uint16_t> depth_mm;
  std::vector<std::uint8_t> rgb;  ///< of the same camera
  Pose T_world_camera;
};

/// The k-th, k < kEmulatedPictures. Rendered once.
[[nodiscard]] const EmulatedPicture& emulated_picture(std::size_t k);

/// Which one the camera sends as its n-th, n counted from 0.
[[nodiscard]] constexpr std::size_t emulated_at(std::size_t n) {
  const std::size_t there_and_back = n % (2 * (kEmulatedPictures - 1));
  return there_and_back < kEmulatedPictures ? there_and_back : 2 * (kEmulatedPictures - 1) - there_and_back;
}

[[nodiscard]] const SyntheticScene& emulated_scene();

}  // namespace scanknit::test
