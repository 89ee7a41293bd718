// Rendered rooms of Replica in the layout of NICE-SLAM (Zhu et al. 2022; github.com/cvg/nice-slam,
// src/utils/datasets.py).
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/numbered_files.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kResults = "results";
constexpr const char* kReplicaTrajectory = "traj.txt";
constexpr const char* kReplicaCamera = "cam_params.json";
constexpr double kReplicaDepthScale = 6553.5;  // 65535 are 10 m

/// Sixteen numbers a line: the 4x4 matrix of a frame, row by row.
Result<std::vector<Result<Pose>>> read_replica_poses(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::vector<Result<Pose>> poses;
  for (const TextLine& line : text_lines(*text)) {
    std::vector<double> numbers;
    for (const std::string_view word : line.words) numbers.push_back(parse_double(word).value_or(NAN));
    const auto pose = pose_from_numbers(numbers);
    poses.push_back(pose ? pose
                         : Result<Pose>(located(pose.error(), path.string() + ":" + std::to_string(line.number))));
  }
  return poses;
}

/// The camera file in the room's folder, else in the one above, which holds all rooms; without one, what other layouts
/// have.
Result<void> read_replica_camera(const Folder& folder, const Limits& limits, Recording& recording) {
  std::error_code code;
  for (const fs::path& place : {folder.path, fs::absolute(folder.path, code).lexically_normal().parent_path()}) {
    const fs::path path = place / kReplicaCamera;
    if (!fs::exists(path, code)) continue;
    const auto json = read_json_object(path, limits);
    if (!json) return json.error();
    const auto& camera = json->contains("camera") && (*json)["camera"].is_object() ? (*json)["camera"] : *json;
    const CameraIntrinsics k{json_side(camera, "w").value_or(0),      json_side(camera, "h").value_or(0),
                             json_number(camera, "fx").value_or(NAN), json_number(camera, "fy").value_or(NAN),
                             json_number(camera, "cx").value_or(NAN), json_number(camera, "cy").value_or(NAN)};
    const double scale = json_number(camera, "scale").value_or(kReplicaDepthScale);
    if (!k.is_valid() || !(scale >= 1 && scale <= 1e7)) {
      return Error{ErrorCode::kInput, "expected {\"camera\": {w, h, fx, fy, cx, cy, scale}}, numbers", path.string()};
    }
    recording.camera = k;
    recording.depth_scale = scale;
    return {};
  }
  const auto camera = find_camera(folder.path, limits);
  if (!camera) return camera.error();
  recording.camera = *camera;
  return {};
}

}  // namespace

bool fits_replica(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kReplicaTrajectory) || !folder.has_folder(kResults)) return false;
  const auto depth = numbered_files(folder.path / kResults, "depth", {".png"}, limits);
  return depth && !depth->empty();
}

Result<Recording> index_replica(const Folder& folder, const AcquireConfig& config) {
  const auto depth = numbered_files(folder.path / kResults, "depth", {".png"}, config.limits);
  if (!depth) return depth.error();
  const auto colour = numbered_files(folder.path / kResults, "frame", {".jpg", ".jpeg", ".png"}, config.limits);
  if (!colour) return colour.error();
  const auto poses = read_replica_poses(folder.path / kReplicaTrajectory, config.limits);
  if (!poses) return poses.error();
  Recording recording{.format = "replica", .folder = folder.path, .depth_scale = kReplicaDepthScale};
  recording.world_up = UpAxis::kZ;
  recording.decode = decode_png_frame;
  const auto camera = read_replica_camera(folder, config.limits, recording);
  if (!camera) return camera.error();
  for (const auto& [number, path] : *depth) {
    FrameEntry entry{.sequence = number, .depth = path};
    entry.colour = file_of(*colour, number);
    if (number < poses->size()) entry.T_world_camera = (*poses)[number];
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
