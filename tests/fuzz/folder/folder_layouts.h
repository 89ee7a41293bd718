// The layouts of recordings whose text files are fuzzed, with pictures that are always the same.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/files/crc32.h"
#include "core/picture/png_codec.h"
#include "scratch_folder.h"

namespace scanknit {

inline constexpr int kFuzzWidth = 16, kFuzzHeight = 12;

/// Numbers as files have them, the lowest byte first.
template <typename T>
void append_number(std::string& text, T number) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    text += static_cast<char>((static_cast<std::uint64_t>(number) >> (8 * i)) & 0xff);
  }
}

/// Half a metre to a metre, if a unit is a millimetre.
inline std::uint16_t fuzz_depth(int x, int y) {
  return static_cast<std::uint16_t>(500 + 20 * x + 10 * y);
}

template <typename Pixel>
std::string png_text(const Image<Pixel>& image) {
  const auto png = encode_png(image, PngEffort::kFast);
  require(png.has_value(), "a small picture becomes a PNG");
  return {png->begin(), png->end()};
}

/// 16 x 12, 16 bits, grey.
inline std::string depth_png() {
  Image<std::uint16_t> image(kFuzzWidth, kFuzzHeight);
  for (int y = 0; y < kFuzzHeight; ++y) {
    for (int x = 0; x < kFuzzWidth; ++x) image.at(x, y) = fuzz_depth(x, y);
  }
  return png_text(image);
}

inline std::string colour_png() {
  return png_text(ColourImage(kFuzzWidth, kFuzzHeight, {200, 100, 50}));
}

/// 16 x 12, 8 bits, grey: white in its middle, of 6 x 4.
inline std::string mask_png() {
  static constexpr std::array<std::uint8_t, 75> kBytes = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00,
      0x10, 0x00, 0x00, 0x00, 0x0c, 0x08, 0x00, 0x00, 0x00, 0x00, 0x4e, 0x8c, 0x62, 0x5d, 0x00, 0x00, 0x00, 0x12, 0x49,
      0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0x60, 0xa0, 0x16, 0xf8, 0x0f, 0x06, 0x94, 0x09, 0x50, 0x06, 0x00, 0x87, 0xc3,
      0x17, 0xe9, 0x47, 0x8a, 0xfe, 0xe3, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  return {kBytes.begin(), kBytes.end()};
}

/// Of fakenect: a header of a line, then the pixels.
inline std::string depth_pgm() {
  std::string text = "P5 16 12 65535\n";
  for (int y = 0; y < kFuzzHeight; ++y) {
    for (int x = 0; x < kFuzzWidth; ++x) append_number(text, fuzz_depth(x, y));
  }
  return text;
}
inline std::string colour_ppm() {
  return "P6 16 12 255\n" + std::string(3 * kFuzzWidth * kFuzzHeight, '\x64');
}

/// Of PCL's image grabber: LZF data of literals alone.
inline std::string depth_pclzf() {
  const std::string pixels = depth_pgm().substr(std::string_view("P5 16 12 65535\n").size());
  constexpr std::size_t kMostLiterals = 32;
  std::string packed;
  for (std::size_t at = 0; at < pixels.size(); at += kMostLiterals) {
    packed += static_cast<char>(kMostLiterals - 1) + pixels.substr(at, kMostLiterals);
  }
  std::string text = "PCLZF";
  append_number(text, std::uint32_t{kFuzzWidth});
  append_number(text, std::uint32_t{kFuzzHeight});
  text += "depth16         ";
  append_number(text, static_cast<std::uint32_t>(packed.size()));
  append_number(text, static_cast<std::uint32_t>(pixels.size()));
  return text + packed;
}

/// A sweep of KITTI: points on a ring, 5 m around the sensor.
inline std::string velodyne_bin() {
  std::string text;
  for (const auto& [x, y] : {std::pair{5.0F, 0.0F}, {0.0F, 5.0F}, {-5.0F, 0.0F}, {0.0F, -5.0F}}) {
    for (const float value : {x, y, 0.5F, 0.25F}) append_number(text, std::bit_cast<std::uint32_t>(value));
  }
  return text;
}

/// A ZIP archive of these files, not compressed.
inline std::string stored_zip(std::initializer_list<std::pair<std::string, std::string>> files) {
  std::string zip, directory;
  for (const auto& [name, content] : files) {
    std::string entry;  // what both headers of a file have
    append_number(entry, std::uint32_t{20});
    entry += std::string(6, '\0');
    append_number(entry, crc32(std::as_bytes(std::span(content))));
    append_number(entry, static_cast<std::uint32_t>(content.size()));
    append_number(entry, static_cast<std::uint32_t>(content.size()));
    append_number(entry, static_cast<std::uint16_t>(name.size()));
    append_number(entry, std::uint16_t{0});
    directory += "PK\1\2";
    append_number(directory, std::uint16_t{20});
    directory += entry + std::string(10, '\0');
    append_number(directory, static_cast<std::uint32_t>(zip.size()));
    directory += name;
    zip += "PK\3\4" + entry + name + content;
  }
  std::string end = "PK\5\6" + std::string(4, '\0');
  append_number(end, static_cast<std::uint16_t>(files.size()));
  append_number(end, static_cast<std::uint16_t>(files.size()));
  append_number(end, static_cast<std::uint32_t>(directory.size()));
  append_number(end, static_cast<std::uint32_t>(zip.size()));
  return zip + directory + end + std::string(2, '\0');
}

/// A recording of Record3D with that metadata, and a frame of 16 x 12 pixels.
inline std::string record3d_zip(const std::string& metadata) {
  std::string pixels;
  for (int i = 0; i < kFuzzWidth * kFuzzHeight; ++i) append_number(pixels, std::bit_cast<std::uint32_t>(0.75F));
  std::string depth = "bvx-";  // a block of LZFSE that is not packed
  append_number(depth, static_cast<std::uint32_t>(pixels.size()));
  depth += pixels + "bvx$";
  return stored_zip({{"metadata", metadata}, {"rgbd/0.depth", depth}});
}

/// What reads a folder.
enum class FolderReader { kFrames, kPictures, kSweeps, kStereo };

struct FuzzedLayout {
  const char* name;
  FolderReader reader;
  std::vector<const char*> texts;                         ///< the files that the input fills, in this order
  std::vector<std::pair<const char*, std::string>> kept;  ///< the files that stay as they are
};

inline std::vector<FuzzedLayout> fuzzed_layouts() {
  using enum FolderReader;
  const std::string depth = depth_png(), colour = colour_png(), mask = mask_png();
  const std::pair<const char*, std::string> left = {"left/000000.png", colour}, right = {"right/000000.png", colour};
  return {
      {"seven_scenes",
       kFrames,
       {"frame-000000.pose.txt", "frame-000001.pose.txt", "camera-intrinsics.txt", "camera_intrinsic.json"},
       {{"frame-000000.depth.png", depth},
        {"frame-000001.depth.png", depth},
        {"frame-000000.color.png", colour},
        {"frame-000001.color.png", colour}}},
      {"tum",
       kFrames,
       {"depth.txt", "rgb.txt", "groundtruth.txt", "camera_intrinsic.json"},
       {{"depth/1.png", depth}, {"depth/2.png", depth}, {"rgb/1.png", colour}, {"rgb/2.png", colour}}},
      {"open3d_log",
       kFrames,
       {"camera_intrinsic.json", "trajectory.log", "timestamps.txt"},
       {{"depth/000000.png", depth}, {"depth/000002.png", depth}, {"color/000000.png", colour}}},
      {"open3d_json", kFrames, {"camera_intrinsic.json", "trajectory.json"}, {{"depth/1.png", depth}}},
      {"nerfstudio",
       kFrames,
       {"transforms.json"},
       {{"d.png", depth}, {"c.png", colour}, {"depth/1.png", depth}, {"images/1.png", colour}}},
      {"phone_lidar",
       kFrames,
       {"frame_00000.json", "frame_00001.json"},
       {{"depth_00000.png", depth}, {"depth_00001.png", depth}, {"frame_00000.jpg", colour}}},
      {"stray_scanner",
       kFrames,
       {"odometry.csv", "camera_matrix.csv"},
       {{"depth/000000.png", depth}, {"depth/000001.png", depth}, {"rgb/000000.png", colour}}},
      {"arkitscenes",
       kFrames,
       {"lowres_wide.traj", "lowres_wide_intrinsics/1_0.100.pincam", "lowres_wide_intrinsics/1_0.200.pincam"},
       {{"lowres_depth/1_0.100.png", depth}, {"lowres_depth/1_0.200.png", depth}, {"lowres_wide/1_0.100.png", colour}}},
      {"polycam",
       kFrames,
       {"corrected_cameras/1.json", "corrected_cameras/2.json"},
       {{"depth/1.png", depth}, {"depth/2.png", depth}, {"corrected_images/1.png", colour}}},
      {"replica",
       kFrames,
       {"traj.txt", "cam_params.json"},
       {{"results/depth000000.png", depth}, {"results/depth000001.png", depth}, {"results/frame000000.png", colour}}},
      {"bop",
       kFrames,
       {"scene_camera.json"},
       {{"depth/000000.png", depth}, {"depth/000001.png", depth}, {"rgb/000000.png", colour}}},
      {"fakenect",
       kFrames,
       {"INDEX.txt", "camera_intrinsic.json"},
       {{"d-1.0-1.pgm", depth_pgm()}, {"d-2.0-2.pgm", depth_pgm()}, {"r-1.0-1.ppm", colour_ppm()}}},
      {"pclzf",
       kFrames,
       {"frame_20121214T142255.814212.xml"},
       {{"frame_20121214T142255.814212_depth.pclzf", depth_pclzf()}}},
      {"pcd", kFrames, {"a.pcd", "b.pcd"}, {}},
      {"record3d", kFrames, {"a.r3d"}, {}},
      {"masked_tum",
       kFrames,
       {"depth.txt", "groundtruth.txt", "camera-intrinsics.txt"},
       {{"depth/1.png", depth}, {"depth/2.png", depth}, {"masks/1.png", mask}, {"masks/2.png", colour}}},
      {"transforms_pictures",
       kPictures,
       {"transforms.json"},
       {{"c.png", colour}, {"m.png", mask}, {"masks/c.png", mask}}},
      {"colmap_pictures",
       kPictures,
       {"sparse/0/cameras.txt", "sparse/0/images.txt"},
       {{"images/c.png", colour}, {"masks/c.png", mask}}},
      {"par_pictures", kPictures, {"a_par.txt"}, {{"c.png", colour}, {"masks/c.png", mask}}},
      {"folder_pictures",
       kPictures,
       {"trajectory.log", "camera_intrinsic.json"},
       {{"color/c.png", colour}, {"masks/c.png", mask}}},
      {"folder_pictures_json",
       kPictures,
       {"trajectory.json", "intrinsics.txt"},
       {{"color/c.png", colour}, {"masks/c.png", mask}}},
      {"kitti",
       kSweeps,
       {"poses.txt", "calib.txt", "times.txt"},
       {{"velodyne/000000.bin", velodyne_bin()}, {"velodyne/000001.bin", velodyne_bin()}}},
      {"stereo", kStereo, {"stereo.yaml", "times.txt", "trajectory.txt"}, {left, right}},
      {"stereo_opencv", kStereo, {"intrinsics.yml", "extrinsics.yml", "trajectory.log"}, {left, right}},
      {"stereo_kalibr", kStereo, {"camchain.yaml"}, {left, right}},
      {"stereo_xml", kStereo, {"stereo.xml"}, {left, right}},
      {"stereo_kitti",
       kStereo,
       {"calib.txt", "times.txt"},
       {{"image_2/000000.png", colour}, {"image_3/000000.png", colour}}},
      {"stereo_euroc",
       kStereo,
       {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/trajectory.txt"},
       {{"mav0/cam0/data/1403636579763555584.png", colour}, {"mav0/cam1/data/1403636579763555584.png", colour}}},
  };
}

}  // namespace scanknit
