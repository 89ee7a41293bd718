// Pictures of known cameras with masks, in a folder.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "acquire/convert/picture_files.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"

namespace scanknit::test {

namespace fs = std::filesystem;

inline constexpr CameraIntrinsics kPictureCamera{64, 48, 60, 61, 31.5, 23.5};
inline constexpr int kPictures = 4;

inline Pose pose_of_picture(int number) {
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(0.3 * number, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(0.1 * number, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.1 * number, -0.2, 1 + 0.05 * number);
  return pose;
}

inline ColourImage picture_of(int number) {
  ColourImage picture(kPictureCamera.width, kPictureCamera.height, Rgb8{40, 40, 40});
  for (int y = 10; y < 30; ++y) {
    for (int x = 20; x < 40 + number; ++x) picture.at(x, y) = Rgb8{200, 100, 50};
  }
  return picture;
}

inline ColourImage mask_picture(int number, std::uint8_t value = 255) {
  ColourImage mask(kPictureCamera.width, kPictureCamera.height);
  for (int y = 10; y < 30; ++y) {
    for (int x = 20; x < 40 + number; ++x) mask.at(x, y) = Rgb8{value, value, value};
  }
  return mask;
}

inline void put_text(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

inline void write_pictures(const fs::path& folder) {
  fs::create_directories(folder);
  for (int i = 0; i < kPictures; ++i) {
    ASSERT_TRUE(write_colour_png(picture_of(i), folder / fmt::format("{:04}.png", i)));
  }
}

inline void write_masks(const fs::path& folder) {
  fs::create_directories(folder);
  for (int i = 0; i < kPictures; ++i) {
    ASSERT_TRUE(write_colour_png(mask_picture(i), folder / fmt::format("{:04}.png", i)));
  }
}

/// The layout with the poses of `trajectory.log`.
inline void write_folder_layout(const fs::path& root) {
  write_pictures(root / "color");
  write_masks(root / "masks");
  std::string log;
  for (int i = 0; i < kPictures; ++i) append_log_pose(log, static_cast<std::size_t>(i), pose_of_picture(i).matrix());
  put_text(root / "trajectory.log", log);
  ASSERT_TRUE(write_camera_json(kPictureCamera, 1000, root / "camera_intrinsic.json"));
}

}  // namespace scanknit::test
