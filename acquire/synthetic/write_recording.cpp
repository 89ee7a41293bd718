#include "acquire/synthetic/write_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <system_error>
#include <vector>

#include "acquire/synthetic/surface_samples.h"
#include "acquire/synthetic/synthetic_source.h"
#include "acquire/synthetic/truth_files.h"
#include "core/atomic_file.h"

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
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(std::as_bytes(std::span(bytes))); !written) return written;
  return file->commit();
}

Result<void> write_depth(const DepthImage& depth_m, double scale, const fs::path& path) {
  cv::Mat picture(depth_m.height(), depth_m.width(), CV_16UC1);
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const long raw = std::lround(static_cast<double>(depth_m.at(x, y)) * scale);
      picture.at<std::uint16_t>(y, x) = raw > kLargestRaw ? std::uint16_t{0} : static_cast<std::uint16_t>(raw);
    }
  }
  return write_picture(picture, ".png", {cv::IMWRITE_PNG_COMPRESSION, 3}, path);
}

Result<void> write_colour(const ColourImage& colour, bool as_jpeg, const fs::path& path) {
  cv::Mat picture(colour.height(), colour.width(), CV_8UC3);
  for (int y = 0; y < colour.height(); ++y) {
    for (int x = 0; x < colour.width(); ++x) {
      const Rgb8& c = colour.at(x, y);
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(c.b, c.g, c.r);
    }
  }
  if (as_jpeg) return write_picture(picture, ".jpg", {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}, path);
  return write_picture(picture, ".png", {cv::IMWRITE_PNG_COMPRESSION, 3}, path);
}

Result<void> write_intrinsics(const SynthConfig& config, const fs::path& path) {
  const CameraIntrinsics& camera = config.intrinsics;
  nlohmann::ordered_json json;
  json["width"] = camera.width;
  json["height"] = camera.height;
  json["intrinsic_matrix"] = {camera.fx, 0.0, 0.0, 0.0, camera.fy, 0.0, camera.cx, camera.cy, 1.0};  // by columns
  json["depth_scale"] = config.depth_scale;
  return write_file_atomically(path, json.dump(2) + "\n");
}

void append_pose(std::string& log, std::size_t frame, const Pose& T_world_camera) {
  log += fmt::format("{} {} {}\n", frame, frame, frame + 1);
  for (int row = 0; row < 4; ++row) {
    const auto& m = T_world_camera.matrix();
    log += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", m(row, 0), m(row, 1), m(row, 2), m(row, 3));
  }
}

/// Removes pictures with names of ours, so that a shorter recording does not end in frames of a longer one.
Result<void> remove_old_pictures(const fs::path& folder) {
  const auto is_ours = [](const fs::path& path) {
    const std::string stem = path.stem().string();
    return stem.size() == 6 && std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; }) &&
           (path.extension() == ".png" || path.extension() == ".jpg");
  };
  std::error_code code;
  std::vector<fs::path> old;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    if (is_ours(entry->path())) old.push_back(entry->path());
  }
  for (std::size_t i = 0; i < old.size() && !code; ++i) fs::remove(old[i], code);
  if (code) return Error{ErrorCode::kOutput, "old frames cannot be removed: " + code.message(), folder.string()};
  return {};
}

Result<void> prepare_folder(const fs::path& folder) {
  std::error_code code;
  const bool is_foreign = fs::exists(folder / "depth", code) && !fs::exists(folder / kGroundTruthFile, code);
  if (is_foreign) {
    return Error{ErrorCode::kOutput, "holds a recording that is not synthetic; choose another folder", folder.string()};
  }
  for (const char* part : {"depth", "color"}) {
    fs::create_directories(folder / part, code);
    if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), (folder / part).string()};
    if (auto removed = remove_old_pictures(folder / part); !removed) return removed;
  }
  return {};
}

Result<void> write_shot(const Shot& shot, std::size_t number, const SynthConfig& config, const fs::path& folder) {
  const fs::path depth_path = folder / "depth" / fmt::format("{:06}.png", number);
  if (auto done = write_depth(shot.depth_m, config.depth_scale, depth_path); !done) return done;
  const char* extension = config.jpeg_colour ? "jpg" : "png";
  return write_colour(shot.exact.colour, config.jpeg_colour,
                      folder / "color" / fmt::format("{:06}.{}", number, extension));
}

}  // namespace

Result<SynthSummary> write_synthetic_recording(const SyntheticScene& scene, const SynthConfig& config,
                                               const fs::path& folder, const SynthProgress& progress,
                                               std::stop_token stop) {
  if (auto valid = validate(config); !valid) return valid.error();
  if (auto ready = prepare_folder(folder); !ready) return ready.error();
  // Written first as well: it marks the folder as ours should the run be killed.
  if (auto marked = write_truth(scene, config, 0, {}, folder); !marked) return marked.error();
  if (auto done = write_intrinsics(config, folder / "camera_intrinsic.json"); !done) return done.error();

  const SyntheticScanner scanner(scene, config);
  std::vector<TruthPoint> points = sample_surface(scene, config.truth_points, config.seed);
  SynthSummary summary;
  summary.truth_points = points.size();
  std::string trajectory;
  for (; summary.frames < scanner.pictures(); ++summary.frames) {
    if (stop.stop_requested()) {
      summary.was_stopped = true;
      break;
    }
    const Shot shot = scanner.shoot(summary.frames);
    count_views(shot.exact, config.intrinsics, shot.T_world_camera, points);
    append_pose(trajectory, summary.frames, shot.T_world_camera);
    if (auto done = write_shot(shot, summary.frames, config, folder); !done) return done.error();
    if (progress) progress(summary.frames + 1, scanner.pictures());
  }
  std::erase_if(points,
                [&](const TruthPoint& point) { return point.views < static_cast<std::uint32_t>(config.min_views); });
  summary.visible_points = points.size();
  if (auto done = write_file_atomically(folder / "trajectory.log", trajectory); !done) return done.error();
  if (auto done = write_truth(scene, config, summary.frames, points, folder); !done) return done.error();
  return summary;
}

}  // namespace scanknit
