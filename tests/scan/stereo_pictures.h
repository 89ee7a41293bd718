// Pairs of pictures of a scene, rendered as a stereo rig takes them.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "core/counter_random.h"
#include "synth/render.h"
#include "tests/core/temporary_folder.h"

namespace scanknit::test {

struct RigOnPaper {
  CameraIntrinsics camera{320, 240, 280, 280, 159.5, 119.5};
  double baseline_m = 0.06;
  RadialLens lens = {};
  double noise = 1.5;  ///< sigma, grey levels of 255
  Pose T_right_left = Pose(Eigen::Translation3d(-0.06, 0, 0));

  [[nodiscard]] std::string yaml() const {
    const CameraIntrinsics& c = camera;
    return fmt::format("left: {{width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}}}\nbaseline: {}\n", c.width,
                       c.height, c.fx, c.fy, c.cx, c.cy, baseline_m);
  }
};

/// Each pixel is the mean of 2 x 2 rays, as a sensor's pixel gathers light from all of its area.
inline ColourImage photograph(const SyntheticScene& scene, const RigOnPaper& rig, const Pose& T_world_camera,
                              std::uint64_t seed) {
  constexpr int kRays = 2;
  const int width = rig.camera.width;
  const int height = rig.camera.height;
  const CameraIntrinsics fine = rig.camera.resized(kRays * width, kRays * height);
  const RenderedView view = render(scene, ViewCamera(fine, rig.lens, {T_world_camera}));
  ColourImage picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int r = 0, g = 0, b = 0;
      for (int k = 0; k < kRays * kRays; ++k) {
        const Rgb8 ray = view.colour.at(kRays * x + k % kRays, kRays * y + k / kRays);
        r += ray.r;
        g += ray.g;
        b += ray.b;
      }
      const auto pixel =
          static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(width) + static_cast<std::uint64_t>(x);
      const double noise = rig.noise * CounterRandom(1, seed, pixel).gaussian();
      const auto mean = [&](int sum) {
        return static_cast<std::uint8_t>(std::clamp(std::lround(sum / double{kRays * kRays} + noise), 0L, 255L));
      };
      picture.at(x, y) = {mean(r), mean(g), mean(b)};
    }
  }
  return picture;
}

/// left/ and right/ with stereo.yaml, and trajectory.log of the left camera.
inline void write_stereo_recording(const SyntheticScene& scene, const RigOnPaper& rig, const std::vector<Pose>& poses,
                                   const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_directories(folder / "right");
  std::string log;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string name = fmt::format("{:06}.png", i);
    const Pose T_world_right = poses[i] * rig.T_right_left.inverse();
    ASSERT_TRUE(write_colour_png(photograph(scene, rig, poses[i], 2 * i), folder / "left" / name));
    ASSERT_TRUE(write_colour_png(photograph(scene, rig, T_world_right, 2 * i + 1), folder / "right" / name));
    append_log_pose(log, i, poses[i].matrix());
  }
  write_text(folder / "stereo.yaml", rig.yaml());
  write_text(folder / "trajectory.log", log);
}

}  // namespace scanknit::test
