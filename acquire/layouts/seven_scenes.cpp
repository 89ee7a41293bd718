// 7-Scenes layout (Shotton et al. 2013): frame-NNNNNN.{color,depth}.{png,jpg}, frame-NNNNNN.pose.txt.
#include <algorithm>
#include <map>
#include <string>

#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

constexpr const char* kPrefix = "frame-";
constexpr double kSevenScenesDepthScale = 1000.0;  // millimetres

std::optional<std::uint64_t> depth_number(const std::string& name) {
  return numbered_name(name, kPrefix, ".depth.png");
}

std::optional<std::uint64_t> colour_number(const std::string& name) {
  for (const char* suffix : {".color.png", ".color.jpg", ".color.jpeg"}) {
    if (const auto number = numbered_name(name, kPrefix, suffix)) return number;
  }
  return std::nullopt;
}

Result<Pose> read_pose(const std::filesystem::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto numbers = parse_numbers(*text);
  if (!numbers) return Error{ErrorCode::kInput, "the pose holds a word that is not a number", path.string()};
  const auto pose = pose_from_numbers(*numbers);
  if (!pose) return located(pose.error(), path);
  return *pose;
}

}  // namespace

bool fits_seven_scenes(const Folder& folder, const Limits&) {
  return std::any_of(folder.files.begin(), folder.files.end(),
                     [](const std::string& name) { return depth_number(name).has_value(); });
}

Result<Recording> index_seven_scenes(const Folder& folder, const AcquireConfig& config) {
  // A number is a frame as soon as one of its files is there: what is missing is then reported.
  std::map<std::uint64_t, FrameEntry> frames;
  for (const std::string& name : folder.files) {
    if (const auto number = depth_number(name)) {
      frames[*number].depth = folder.path / name;
    } else if (const auto of_colour = colour_number(name)) {
      frames[*of_colour].colour = folder.path / name;
    } else if (const auto of_pose = numbered_name(name, kPrefix, ".pose.txt")) {
      frames[*of_pose].T_world_camera = read_pose(folder.path / name, config.limits);
    }
  }
  const auto depth_scale = find_depth_scale(folder.path, config.limits);
  if (!depth_scale) return depth_scale.error();
  Recording recording{
      .format = "7-scenes", .folder = folder.path, .depth_scale = depth_scale->value_or(kSevenScenesDepthScale)};
  recording.decode = decode_png_frame;
  for (auto& [number, entry] : frames) {
    entry.sequence = number;
    if (entry.depth.empty()) {
      const std::string digits = std::to_string(number);
      const std::string padded = std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits;
      entry.depth = folder.path / (kPrefix + padded + ".depth.png");
    }
    recording.entries.push_back(std::move(entry));
  }
  const auto camera = find_camera(folder.path, config.limits);
  if (!camera) return camera.error();
  recording.camera = *camera;
  return recording;
}

}  // namespace scanknit
