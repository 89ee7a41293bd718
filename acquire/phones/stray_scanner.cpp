// Recordings of Stray Scanner (github.com/strayrobots/scanner, docs/format.md), an app of phones and tablets with
// LiDAR.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "acquire/parse/numbered_files.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOdometry = "odometry.csv";
constexpr const char* kStrayCamera = "camera_matrix.csv";
constexpr const char* kStrayVideo = "rgb.mp4";
constexpr double kStrayDepthScale = 1000.0;  // millimetres
constexpr std::array kPoseColumns = {"timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr std::array kCameraColumns = {"fx", "fy", "cx", "cy"};  // behind those, in newer recordings

// Cameras are those of the video's pictures. The text files do not tell its size; ARKit's is this one.
constexpr int kVideoWidth = 1920, kVideoHeight = 1440;

Result<std::string> read_csv(const fs::path& path, const Limits& limits) {
  auto text = read_text_file(path, limits.max_text_bytes);
  if (text) std::replace(text->begin(), text->end(), ',', ' ');
  return text;
}

/// A camera of pictures of that size has its principal point near their middle.
bool is_of_video(const CameraIntrinsics& camera) {
  constexpr double kFarthest = 0.15;  // of the width
  return camera.is_valid() && camera.fx > 0 && camera.fy > 0 &&
         std::abs(camera.cx - kVideoWidth / 2.0) < kFarthest * kVideoWidth &&
         std::abs(camera.cy - kVideoHeight / 2.0) < kFarthest * kVideoWidth;
}

bool has_words(const TextLine& line, std::size_t first, std::span<const char* const> words) {
  return line.words.size() >= first + words.size() &&
         std::equal(words.begin(), words.end(), line.words.begin() + static_cast<std::ptrdiff_t>(first));
}

std::optional<CameraIntrinsics> row_camera(const TextLine& row) {
  std::array<double, kCameraColumns.size()> k{};
  if (row.words.size() < kPoseColumns.size() + k.size()) return std::nullopt;
  for (std::size_t i = 0; i < k.size(); ++i) {
    const auto number = parse_double(row.words[kPoseColumns.size() + i]);
    if (!number) return std::nullopt;
    k[i] = *number;
  }
  const CameraIntrinsics camera{kVideoWidth, kVideoHeight, k[0], k[1], k[2], k[3]};
  return is_of_video(camera) ? std::optional(camera) : std::nullopt;
}

/// The app has already turned ARKit's cameras, so that their y axis points down.
Result<Pose> row_pose(const TextLine& row) {
  if (row.words.size() < kPoseColumns.size()) return Error{ErrorCode::kInput, "the line is short"};
  TextLine tum{row.number, row.words};
  tum.words.erase(tum.words.begin() + 1);  // the frame's number
  return parse_tum_pose(tum);
}

/// Adds time, pose and camera to the frames; makes those that have no depth.
Result<void> add_odometry(const fs::path& path, const Limits& limits, std::map<std::uint64_t, FrameEntry>& frames,
                          std::vector<std::string>& warnings) {
  const auto text = read_csv(path, limits);
  if (!text) return text.error();
  const auto lines = text_lines(*text);
  if (lines.empty() || !has_words(lines.front(), 0, kPoseColumns)) {
    return Error{ErrorCode::kInput, "expected the first line 'timestamp, frame, x, y, z, qx, qy, qz, qw'",
                 path.string()};
  }
  const bool has_cameras = has_words(lines.front(), kPoseColumns.size(), kCameraColumns);
  std::size_t nameless = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const TextLine& row = lines[i];
    const auto number = row.words.size() > 1 ? parse_integer(row.words[1]) : std::nullopt;
    if (!number || *number < 0) {
      ++nameless;
      continue;
    }
    FrameEntry& frame = frames[static_cast<std::uint64_t>(*number)];
    frame.timestamp_ns = parse_seconds_ns(row.words[0]);
    const auto pose = row_pose(row);
    frame.T_world_camera =
        pose ? pose : Result<Pose>(located(pose.error(), path.string() + ":" + std::to_string(row.number)));
    if (has_cameras) frame.camera = row_camera(row);
  }
  if (nameless > 0) {
    warnings.push_back(std::to_string(nameless) + " lines of " + kOdometry + " name no frame and are left out");
  }
  return {};
}

/// By the frames' numbers, also where these are counted from 1, as ffmpeg counts what it takes out of a video.
Result<void> add_stray_colour(const Folder& folder, const Limits& limits, std::map<std::uint64_t, FrameEntry>& frames,
                              std::vector<std::string>& warnings) {
  const auto colour = numbered_files_below(folder, "rgb", "", {".jpg", ".jpeg", ".png"}, limits);
  if (!colour) return colour.error();
  if (colour->empty() && folder.has_file(kStrayVideo)) {
    warnings.push_back(std::string("colour is not read: it is a video; make pictures of it in the recording's folder "
                                   "with 'mkdir rgb; ffmpeg -i ") +
                       kStrayVideo + " -fps_mode passthrough -start_number 0 -q:v 2 rgb/%06d.jpg'");
  }
  if (frames.empty()) return {};
  const bool counts_from_1 = !colour->contains(frames.begin()->first) && colour->contains(frames.rbegin()->first + 1);
  for (auto& [number, frame] : frames) frame.colour = file_of(*colour, number + (counts_from_1 ? 1 : 0));
  return {};
}

/// The camera for all frames; nothing: there is none of that size.
Result<std::optional<CameraIntrinsics>> read_stray_camera(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kStrayCamera)) return std::optional<CameraIntrinsics>();
  const auto text = read_csv(folder.path / kStrayCamera, limits);
  if (!text) return text.error();
  auto camera = parse_camera_matrix(*text);
  if (!camera) return located(camera.error(), folder.path / kStrayCamera);
  camera->width = kVideoWidth;
  camera->height = kVideoHeight;
  return is_of_video(*camera) ? std::optional(*camera) : std::nullopt;
}

}  // namespace

bool fits_stray_scanner(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kOdometry) || !folder.has_folder("depth")) return false;
  const auto depth = numbered_files(folder.path / "depth", "", {".png"}, limits);
  return depth && !depth->empty();
}

Result<Recording> index_stray_scanner(const Folder& folder, const AcquireConfig& config) {
  const auto depth = numbered_files(folder.path / "depth", "", {".png"}, config.limits);
  if (!depth) return depth.error();
  const auto confidence = numbered_files_below(folder, "confidence", "", {".png"}, config.limits);
  if (!confidence) return confidence.error();
  const auto camera = read_stray_camera(folder, config.limits);
  if (!camera) return camera.error();

  Recording recording{.format = "stray-scanner", .folder = folder.path, .depth_scale = kStrayDepthScale};
  recording.frames_bring_camera = true;
  recording.world_up = UpAxis::kY;  // ARKit's worlds stand upright
  recording.decode = decode_png_frame_of_one_lens;
  std::map<std::uint64_t, FrameEntry> frames;
  for (const auto& [number, path] : *depth) frames[number].depth = path;
  const auto odometry = add_odometry(folder.path / kOdometry, config.limits, frames, recording.warnings);
  if (!odometry) return odometry.error();
  const auto colour = add_stray_colour(folder, config.limits, frames, recording.warnings);
  if (!colour) return colour.error();
  bool has_camera = false;
  for (auto& [number, entry] : frames) {
    entry.sequence = number;
    entry.confidence = file_of(*confidence, number);
    if (!entry.camera) entry.camera = *camera;
    has_camera |= entry.camera.has_value();
    if (entry.depth.empty()) {
      const std::string digits = std::to_string(number);
      entry.depth =
          folder.path / "depth" / (std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits + ".png");
    }
    recording.entries.push_back(std::move(entry));
  }
  if (!has_camera && !config.intrinsics) {
    return Error{ErrorCode::kInput,
                 "states no camera of pictures of 1920 x 1440 pixels, which the app's videos have; give that of depth "
                 "as acquire.intrinsics=[fx,fy,cx,cy]",
                 (folder.path / kStrayCamera).string()};
  }
  return recording;
}

}  // namespace scanknit
