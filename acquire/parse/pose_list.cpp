#include "acquire/parse/pose_list.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLog = "trajectory.log";
constexpr const char* kJson = "trajectory.json";
constexpr std::size_t kLinesPerPose = 5;

// Five lines a pose: three integers, then the 4x4 matrix row by row.
Result<std::vector<Result<Pose>>> read_log(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto lines = text_lines(*text);
  std::vector<Result<Pose>> poses;
  for (std::size_t first = 0; first < lines.size(); first += kLinesPerPose) {
    const std::string where = path.string() + ":" + std::to_string(lines[first].number);
    std::vector<double> numbers;
    bool is_numeric = true;
    for (std::size_t i = first + 1; i < std::min(first + kLinesPerPose, lines.size()); ++i) {
      for (const std::string_view word : lines[i].words) {
        const auto number = parse_double(word);
        is_numeric &= number.has_value();
        numbers.push_back(number.value_or(0));
      }
    }
    Result<Pose> pose = is_numeric ? pose_from_numbers(numbers)
                                   : Result<Pose>(Error{ErrorCode::kInput, "the pose holds a word that is no number"});
    poses.push_back(pose ? pose : Result<Pose>(Error{ErrorCode::kInput, pose.error().message, where}));
  }
  return poses;
}

// Open3D's PinholeCameraTrajectory: world-to-camera matrices, column by column.
Result<std::vector<Result<Pose>>> read_json(const fs::path& path, const Limits& limits) {
  const Error malformed{ErrorCode::kInput, "not a PinholeCameraTrajectory of Open3D", path.string()};
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("parameters") || !json["parameters"].is_array()) return malformed;
  std::vector<Result<Pose>> poses;
  for (const auto& parameter : json["parameters"]) {
    if (!parameter.is_object() || !parameter.contains("extrinsic") || !parameter["extrinsic"].is_array()) {
      return malformed;
    }
    std::vector<double> numbers;
    for (const auto& value : parameter["extrinsic"]) {
      if (!value.is_number()) return malformed;
      numbers.push_back(value.get<double>());
    }
    if (numbers.size() != 16) return malformed;
    const auto T_camera_world = pose_from_matrix(Eigen::Map<const Eigen::Matrix4d>(numbers.data()));
    poses.push_back(T_camera_world ? Result<Pose>(T_camera_world->inverse())
                                   : Result<Pose>(located(T_camera_world.error(), path)));
  }
  return poses;
}

}  // namespace

bool has_pose_list(const Folder& folder) {
  return folder.has_file(kLog) || folder.has_file(kJson);
}

Result<std::vector<Result<Pose>>> read_pose_list(const Folder& folder, const Limits& limits) {
  if (folder.has_file(kLog)) return read_log(folder.path / kLog, limits);
  if (folder.has_file(kJson)) return read_json(folder.path / kJson, limits);
  return std::vector<Result<Pose>>();
}

}  // namespace scanknit
