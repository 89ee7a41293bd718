// Scenes of ARKitScenes (Baruch et al. 2021; github.com/apple/ARKitScenes, DATA.md), both of its raw and of its 3DOD
// part.
#include <algorithm>
#include <array>
#include <string>

#include "acquire/parse/timed_poses.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDepthAsset = "lowres_depth";
constexpr const char* kColourAsset = "lowres_wide";
constexpr const char* kConfidenceAsset = "confidence";
constexpr const char* kCameraAsset = "lowres_wide_intrinsics";
constexpr const char* kTrajectoryAsset = "lowres_wide.traj";
constexpr double kArkitScenesDepthScale = 1000.0;           // millimetres
constexpr std::int64_t kMostBetweenPoses_ns = 150'000'000;  // ten a second, about
constexpr std::int64_t kMillisecond_ns = 1'000'000;

/// The time in "41069021_3065.350.png".
std::optional<std::int64_t> time_in_name(std::string_view name, std::string_view suffix) {
  if (!name.ends_with(suffix)) return std::nullopt;
  name.remove_suffix(suffix.size());
  const std::size_t line = name.find_last_of('_');
  return line == std::string_view::npos ? std::nullopt : parse_seconds_ns(name.substr(line + 1));
}

/// "seconds rx ry rz tx ty tz": world to camera, the rotation as its axis times its angle.
Result<Pose> parse_traj_pose(const TextLine& line) {
  Eigen::Matrix<double, 6, 1> values;
  if (line.words.size() != 7) return Error{ErrorCode::kInput, "expected 'seconds rx ry rz tx ty tz'"};
  for (int i = 0; i < 6; ++i) {
    const auto number = parse_double(line.words[static_cast<std::size_t>(i) + 1]);
    if (!number) return Error{ErrorCode::kInput, "expected 'seconds rx ry rz tx ty tz'"};
    values[i] = *number;
  }
  const Eigen::Vector3d axis = values.head<3>();
  const double angle = axis.norm();
  Eigen::Matrix4d T_camera_world = Eigen::Matrix4d::Identity();
  if (angle > 0) T_camera_world.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix();
  T_camera_world.topRightCorner<3, 1>() = values.tail<3>();
  const auto pose = pose_from_matrix(T_camera_world);
  return pose ? Result<Pose>(pose->inverse()) : pose;
}

Result<std::vector<TimedPose>> read_traj(const Folder& folder, const Limits& limits) {
  std::vector<TimedPose> poses;
  if (!folder.has_file(kTrajectoryAsset)) return poses;
  const fs::path path = folder.path / kTrajectoryAsset;
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  for (const TextLine& line : text_lines(*text)) {
    const auto time_ns = parse_seconds_ns(line.words[0]);
    if (!time_ns) continue;
    const auto pose = parse_traj_pose(line);
    poses.push_back(
        {*time_ns,
         pose ? pose : Result<Pose>(located(pose.error(), path.string() + ":" + std::to_string(line.number)))});
  }
  sort_by_time(poses);
  return poses;
}

/// "width height fx fy cx cy"
Result<CameraIntrinsics> read_pincam(const fs::path& path, const Limits& limits) {
  constexpr double kMostSide = 1 << 20;
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto k = parse_numbers(*text);
  if (k && k->size() == 6 && (*k)[0] >= 1 && (*k)[0] <= kMostSide && (*k)[1] >= 1 && (*k)[1] <= kMostSide) {
    const CameraIntrinsics camera{
        static_cast<int>((*k)[0]), static_cast<int>((*k)[1]), (*k)[2], (*k)[3], (*k)[4], (*k)[5]};
    if (camera.is_valid()) return camera;
  }
  return Error{ErrorCode::kInput, "expected 'width height fx fy cx cy'", path.string()};
}

/// The asset of this time: data sets round it either way, so that names differ by a millisecond.
class TimedFiles {
 public:
  static Result<TimedFiles> of(const Folder& folder, const char* asset, std::string_view suffix, const Limits& limits) {
    TimedFiles files;
    if (!folder.has_folder(asset)) return files;
    const auto listing = list_folder(folder.path / asset, limits);
    if (!listing) return listing.error();
    for (const std::string& name : listing->files) {
      if (const auto time_ns = time_in_name(name, suffix)) files.by_time_.emplace(*time_ns, listing->path / name);
    }
    return files;
  }

  [[nodiscard]] const std::map<std::int64_t, fs::path>& all() const { return by_time_; }
  [[nodiscard]] fs::path at(std::int64_t time_ns) const {
    for (const std::int64_t off : {std::int64_t{0}, -kMillisecond_ns, kMillisecond_ns}) {
      const auto found = by_time_.find(time_ns + off);
      if (found != by_time_.end()) return found->second;
    }
    return {};
  }

 private:
  std::map<std::int64_t, fs::path> by_time_;
};

OrDrop<DecodedFrame> decode_arkitscenes_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame == nullptr || !entry.camera) return decoded;
  frame->camera = entry.camera->resized(frame->depth_m.width(), frame->depth_m.height());
  return decoded;
}

}  // namespace

bool fits_arkitscenes(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kTrajectoryAsset) && !folder.has_folder(kCameraAsset)) return false;
  const auto depth = TimedFiles::of(folder, kDepthAsset, ".png", limits);
  return depth && !depth->all().empty();
}

Result<Recording> index_arkitscenes(const Folder& folder, const AcquireConfig& config) {
  std::array<TimedFiles, 4> assets;
  const std::array names = {kDepthAsset, kColourAsset, kConfidenceAsset, kCameraAsset};
  for (std::size_t i = 0; i < assets.size(); ++i) {
    auto files = TimedFiles::of(folder, names[i], names[i] == kCameraAsset ? ".pincam" : ".png", config.limits);
    if (!files) return files.error();
    assets[i] = *std::move(files);
  }
  const auto& [depth, colour, confidence, cameras] = assets;
  const auto poses = read_traj(folder, config.limits);
  if (!poses) return poses.error();
  Recording recording{.format = "arkitscenes", .folder = folder.path, .depth_scale = kArkitScenesDepthScale};
  recording.frames_bring_camera = true;
  recording.world_up = UpAxis::kZ;
  recording.decode = decode_arkitscenes_frame;
  for (const auto& [time_ns, path] : depth.all()) {
    FrameEntry entry{.sequence = recording.entries.size(), .timestamp_ns = time_ns, .depth = path};
    entry.colour = colour.at(time_ns);
    entry.confidence = confidence.at(time_ns);
    entry.T_world_camera = pose_at(*poses, time_ns, kMostBetweenPoses_ns);
    if (const fs::path file = cameras.at(time_ns); !file.empty()) {
      const auto camera = read_pincam(file, config.limits);
      if (camera) {
        entry.camera = *camera;
      } else if (!config.intrinsics) {
        entry.fault = Drop{DropReason::kNoIntrinsics, camera.error()};
      }
    }
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
