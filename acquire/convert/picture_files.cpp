#include "acquire/convert/picture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 95;
constexpr long kLargestRaw = 65534;  // 65535 means "no return" to many readers

// An encoder's answer into a file.
Result<void> write_picture(const Result<std::vector<std::uint8_t>>& encoded, const fs::path& path) {
  if (!encoded) return located(encoded.error(), path);
  return write_bytes(std::as_bytes(std::span(*encoded)), path);
}

}  // namespace

Image<std::uint16_t> to_raw_depth(const DepthImage& depth_m, double units_per_metre) {
  Image<std::uint16_t> raw(depth_m.width(), depth_m.height());
  std::transform(depth_m.pixels().begin(), depth_m.pixels().end(), raw.pixels().begin(), [&](float z) {
    const double units = std::round(static_cast<double>(z) * units_per_metre);
    return units > kLargestRaw ? std::uint16_t{0} : static_cast<std::uint16_t>(units);
  });
  return raw;
}

Result<void> write_bytes(std::span<const std::byte> bytes, const fs::path& path) {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(bytes); !written) return written;
  return file->commit();
}

Result<void> write_depth_png(const Image<std::uint16_t>& raw, const fs::path& path) {
  return write_picture(encode_png(raw, PngEffort::kMedium), path);
}

Result<void> write_colour_png(const ColourImage& colour, const fs::path& path) {
  return write_picture(encode_png(colour, PngEffort::kMedium), path);
}

Result<void> write_colour_jpeg(const ColourImage& colour, const fs::path& path) {
  return write_picture(encode_jpeg(colour, kJpegQuality), path);
}

Result<void> write_camera_json(const CameraIntrinsics& camera, double units_per_metre, const fs::path& path) {
  nlohmann::ordered_json json;
  json["width"] = camera.width;
  json["height"] = camera.height;
  json["intrinsic_matrix"] = {camera.fx, 0.0, 0.0, 0.0, camera.fy, 0.0, camera.cx, camera.cy, 1.0};  // by columns
  json["depth_scale"] = units_per_metre;
  return write_file_atomically(path, json.dump(2) + "\n");
}

void append_matrix(std::string& text, const Eigen::Matrix4d& m) {
  for (int row = 0; row < 4; ++row) {
    text += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", m(row, 0), m(row, 1), m(row, 2), m(row, 3));
  }
}

void append_log_pose(std::string& log, std::size_t frame, const Eigen::Matrix4d& T_world_camera) {
  log += fmt::format("{} {} {}\n", frame, frame, frame + 1);
  append_matrix(log, T_world_camera);
}

}  // namespace scanknit
