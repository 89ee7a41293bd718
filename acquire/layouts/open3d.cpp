// Open3D / Redwood layout (Choi, Zhou, Koltun 2015): depth/, color/ or image/, camera_intrinsic.json, trajectory.log.
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "acquire/parse/pose_list.h"
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
constexpr const char* kTimes = "timestamps.txt";
constexpr double kOpen3dDepthScale = 1000.0;  // millimetres

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
    const auto match = by_stem.find(entry.depth->stem().string());
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
  const bool has_company = folder.has_file("camera_intrinsic.json") || has_pose_list(folder) ||
                           std::any_of(kColourFolders.begin(), kColourFolders.end(),
                                       [&](const char* name) { return folder.has_folder(name); });
  if (!has_company) return false;
  const auto depth = list_pictures(folder.path / kDepthFolder, false, limits);
  return depth && !depth->empty();
}

Result<Recording> index_open3d(const Folder& folder, const AcquireConfig& config) {
  const auto depth = list_pictures(folder.path / kDepthFolder, false, config.limits);
  if (!depth) return depth.error();
  const auto poses = read_pose_list(folder, config.limits);
  if (!poses) return poses.error();

  const auto depth_scale = find_depth_scale(folder.path, config.limits);
  if (!depth_scale) return depth_scale.error();
  Recording recording{
      .format = "open3d", .folder = folder.path, .depth_scale = depth_scale->value_or(kOpen3dDepthScale)};
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
