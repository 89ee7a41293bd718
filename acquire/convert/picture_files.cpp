#include "acquire/convert/picture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 95;
constexpr long kLargestRaw = 65534;  // 65535 means "no return" to many readers

Result<void> write_picture(const cv::Mat& picture, const char* extension, const std::vector<int>& parameters,
                           const fs::path& path) {
  std::vector<unsigned char> bytes;
  try {
    if (!cv::imencode(extension, picture, bytes, parameters)) {
      return Error{ErrorCode::kInternal, "the picture cannot be encoded", path.string()};
    }
  } catch (const cv::Exception& e) {
    return Error{ErrorCode::kInternal, e.what(), path.string()};
  }
  return write_bytes(std::as_bytes(std::span(bytes)), path);
}

cv::Mat to_bgr(const ColourImage& colour) {
  cv::Mat picture(colour.height(), colour.width(), CV_8UC3);
  for (int y = 0; y < colour.height(); ++y) {
    for (int x = 0; x < colour.width(); ++x) {
      const Rgb8& c = colour.at(x, y);
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(c.b, c.g, c.r);
    }
  }
  return picture;
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
  cv::Mat picture(raw.height(), raw.width(), CV_16UC1);
  for (int y = 0; y < raw.height(); ++y) {
    std::copy(raw.row(y).begin(), raw.row(y).end(), picture.ptr<std::uint16_t>(y));
  }
  return write_picture(picture, ".png", {cv::IMWRITE_PNG_COMPRESSION, 3}, path);
}

Result<void> write_colour_png(const ColourImage& colour, const fs::path& path) {
  return write_picture(to_bgr(colour), ".png", {cv::IMWRITE_PNG_COMPRESSION, 3}, path);
}

Result<void> write_colour_jpeg(const ColourImage& colour, const fs::path& path) {
  return write_picture(to_bgr(colour), ".jpg", {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}, path);
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
