// Open3D / Redwood layout (Choi, Zhou, Koltun 2015): depth/, color/ or image/, camera_intrinsic.json, trajectory.log.
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDepthFolder = "depth";
constexpr std::array kColourFolders = {"color", "image", "rgb"};
constexpr const char* kLog = "trajectory.log";
constexpr const char* kJson = "trajectory.json";
constexpr const char* kTimes = "timestamps.txt";
constexpr double kOpen3dDepthScale = 1000.0;  // millimetres
constexpr std::size_t kLinesPerPose = 5;

struct Picture {
  std::string stem;
  fs::path path;
};

// In natural order, which list_folder keeps.
Result<std::vector<Picture>> list_pictures(const fs::path& folder, bool with_jpeg, const Limits& limits) {
  const auto listing = list_folder(folder, limits);
  if (!listing) return listing.error();
  std::vector<Picture> pictures;
  for (const std::string& name : listing->files) {
    const fs::path file(name);
    const std::string extension = lower_case(file.extension().string());
    const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
    if (extension == ".png" || (with_jpeg && is_jpeg)) pictures.push_back({file.stem().string(), folder / file});
  }
  return pictures;
}

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

Result<std::vector<Result<Pose>>> read_trajectory(const Folder& folder, const Limits& limits) {
  if (folder.has_file(kLog)) return read_log(folder.path / kLog, limits);
  if (folder.has_file(kJson)) return read_json(folder.path / kJson, limits);
  return std::vector<Result<Pose>>();
}

// The frame numbers that the depth pictures' names state; nothing unless all do and no two agree.
std::optional<std::vector<std::uint64_t>> frame_numbers(const std::vector<Picture>& depth) {
  std::vector<std::uint64_t> numbers;
  for (const Picture& picture : depth) {
    const auto number = numbered_name(picture.stem, "", "");
    if (!number || (!numbers.empty() && *number <= numbers.back())) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

// One entry a depth picture, in order. When pictures are missing among numbered ones, the trajectory (one pose a frame)
// tells: a missing number keeps its entry, and is dropped with its name instead of shifting all later poses.
std::vector<FrameEntry> make_entries(const std::vector<Picture>& depth, std::size_t poses) {
  std::vector<FrameEntry> entries;
  const auto numbers = frame_numbers(depth);
  const std::uint64_t first = numbers && !numbers->empty() && numbers->front() != 0 ? 1 : 0;
  const bool has_gaps = numbers && depth.size() < poses && !depth.empty() && numbers->back() - first < poses;
  if (!has_gaps) {
    for (std::size_t i = 0; i < depth.size(); ++i) {
      entries.push_back({.sequence = numbers ? (*numbers)[i] : i, .depth = depth[i].path});
    }
    return entries;
  }
  std::size_t next = 0;
  for (std::uint64_t number = first; number < first + poses; ++number) {
    FrameEntry entry{.sequence = number};
    if (next < depth.size() && (*numbers)[next] == number) {
      entry.depth = depth[next++].path;
    } else {
      const std::string digits = std::to_string(number);
      const std::size_t width = depth.front().stem.size();
      entry.depth = depth.front().path.parent_path() /
                    (std::string(width - std::min(width, digits.size()), '0') + digits + ".png");
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

// By name where any name agrees, else by order.
Result<void> add_colour(const std::vector<Picture>& colour, const fs::path& folder, std::vector<FrameEntry>& entries) {
  std::map<std::string, fs::path> by_stem;
  for (const Picture& picture : colour) by_stem.emplace(picture.stem, picture.path);
  bool agrees = false;
  for (FrameEntry& entry : entries) {
    const auto match = by_stem.find(entry.depth.stem().string());
    if (match == by_stem.end()) continue;
    entry.colour = match->second;
    agrees = true;
  }
  if (agrees || colour.empty()) return {};
  if (colour.size() != entries.size()) {
    return Error{ErrorCode::kInput,
                 std::to_string(colour.size()) + " colour pictures for " + std::to_string(entries.size()) +
                     " depth pictures, and no name agrees: which belongs to which is unknown",
                 folder.string()};
  }
  for (std::size_t i = 0; i < entries.size(); ++i) entries[i].colour = colour[i].path;
  return {};
}

// One "seconds" a line and frame.
Result<void> add_times(const fs::path& path, const Limits& limits, std::vector<FrameEntry>& entries) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto lines = text_lines(*text);
  for (std::size_t i = 0; i < std::min(lines.size(), entries.size()); ++i) {
    entries[i].timestamp_ns = parse_seconds_ns(lines[i].words[0]);
    if (!entries[i].timestamp_ns) {
      return Error{ErrorCode::kInput, "expected a time in seconds",
                   path.string() + ":" + std::to_string(lines[i].number)};
    }
  }
  return {};
}

}  // namespace

bool fits_open3d(const Folder& folder, const Limits& limits) {
  if (!folder.has_folder(kDepthFolder)) return false;
  const bool has_company = folder.has_file("camera_intrinsic.json") || folder.has_file(kLog) ||
                           folder.has_file(kJson) ||
                           std::any_of(kColourFolders.begin(), kColourFolders.end(),
                                       [&](const char* name) { return folder.has_folder(name); });
  if (!has_company) return false;
  const auto depth = list_pictures(folder.path / kDepthFolder, false, limits);
  return depth && !depth->empty();
}

Result<Recording> index_open3d(const Folder& folder, const AcquireConfig& config) {
  const auto depth = list_pictures(folder.path / kDepthFolder, false, config.limits);
  if (!depth) return depth.error();
  const auto poses = read_trajectory(folder, config.limits);
  if (!poses) return poses.error();

  Recording recording{.format = "open3d",
                      .folder = folder.path,
                      .depth_scale = find_depth_scale(folder.path, config.limits).value_or(kOpen3dDepthScale)};
  recording.decode = decode_png_frame;
  recording.entries = make_entries(*depth, poses->size());
  for (std::size_t i = 0; i < std::min(recording.entries.size(), poses->size()); ++i) {
    recording.entries[i].T_world_camera = (*poses)[i];
  }
  for (const char* name : kColourFolders) {
    if (!folder.has_folder(name)) continue;
    const auto colour = list_pictures(folder.path / name, true, config.limits);
    if (!colour) return colour.error();
    if (const auto added = add_colour(*colour, folder.path, recording.entries); !added) return added.error();
    break;
  }
  if (folder.has_file(kTimes)) {
    const auto added = add_times(folder.path / kTimes, config.limits, recording.entries);
    if (!added) return added.error();
  }
  const auto camera = find_camera(folder.path, config.limits);
  if (!camera) return camera.error();
  recording.camera = *camera;
  return recording;
}

}  // namespace scanknit
