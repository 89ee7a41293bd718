// A scene of a BOP data set (Hodan et al. 2018; github.com/thodan/bop_toolkit, docs/bop_datasets_format.md).
#include <array>
#include <string>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/numbered_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

constexpr const char* kSceneCamera = "scene_camera.json";
constexpr double kMillimetresPerMetre = 1000.0;

/// World to camera, in millimetres. Nothing: the data set has no poses.
std::optional<Result<Pose>> bop_pose(const nlohmann::json& image) {
  if (!image.contains("cam_R_w2c") && !image.contains("cam_t_w2c")) return std::nullopt;
  const auto rotation = json_numbers(image, "cam_R_w2c", 9);
  const auto translation = json_numbers(image, "cam_t_w2c", 3);
  if (!rotation || !translation) {
    return Error{ErrorCode::kInput, "cam_R_w2c, cam_t_w2c: expected nine and three numbers"};
  }
  Eigen::Matrix4d T_camera_world = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 9; ++i) T_camera_world(i / 3, i % 3) = (*rotation)[static_cast<std::size_t>(i)];
  for (int i = 0; i < 3; ++i) {
    T_camera_world(i, 3) = (*translation)[static_cast<std::size_t>(i)] / kMillimetresPerMetre;
  }
  const auto pose = pose_from_matrix(T_camera_world);
  return pose ? Result<Pose>(pose->inverse()) : pose;
}

/// The image's camera, unit and pose.
void read_bop_image(const nlohmann::json& image, const AcquireConfig& config, const std::string& where,
                    FrameEntry& entry) {
  const auto refuse = [&](DropReason reason, const char* what) { entry.fault = make_drop(reason, what, where); };
  if (!image.is_object()) return refuse(DropReason::kUnreadable, "expected an object");
  if (const auto k = json_numbers(image, "cam_K", 9)) {
    entry.camera = CameraIntrinsics{0, 0, (*k)[0], (*k)[4], (*k)[2], (*k)[5]};
  } else if (!config.intrinsics) {
    refuse(DropReason::kNoIntrinsics, "cam_K: expected nine numbers");
  }
  const double scale = kMillimetresPerMetre / json_number(image, "depth_scale").value_or(1);
  if (scale >= 1 && scale <= 1e7) {
    entry.depth_scale = scale;
  } else if (!config.depth_scale) {
    refuse(DropReason::kUnreadable, "depth_scale: expected millimetres of one raw unit, 0.0001 to 1000");
  }
  auto pose = bop_pose(image);
  if (pose && !*pose) pose = Result<Pose>(located(pose->error(), where));
  entry.T_world_camera = pose;
}

OrDrop<DecodedFrame> decode_bop_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame != nullptr) frame->camera = entry.camera.copy();
  return decoded;
}

}  // namespace

bool fits_bop(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kSceneCamera) || !folder.has_folder("depth")) return false;
  const auto depth = numbered_files(folder.path / "depth", "", {".png"}, limits);
  return depth && !depth->empty();
}

Result<Recording> index_bop(const Folder& folder, const AcquireConfig& config) {
  const std::filesystem::path path = folder.path / kSceneCamera;
  const auto cameras = read_json_object(path, config.limits);
  if (!cameras) return cameras.error();
  const auto depth = numbered_files(folder.path / "depth", "", {".png"}, config.limits);
  if (!depth) return depth.error();
  const auto colour =
      numbered_files_below(folder, folder.has_folder("rgb") ? "rgb" : "gray", "", {".png", ".jpg"}, config.limits);
  if (!colour) return colour.error();
  Recording recording{.format = "bop", .folder = folder.path};
  recording.frames_bring_camera = true;
  recording.decode = decode_bop_frame;
  for (const auto& [number, file] : *depth) {
    FrameEntry entry{.sequence = number, .depth = file};
    entry.colour = file_of(*colour, number);
    const auto image = cameras->find(std::to_string(number));
    if (image == cameras->end()) {
      entry.fault = make_drop(DropReason::kNoIntrinsics, "names no image " + std::to_string(number), path);
    } else {
      read_bop_image(*image, config, path.string() + ": image " + std::to_string(number), entry);
    }
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
