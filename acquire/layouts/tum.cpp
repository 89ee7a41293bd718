// TUM RGB-D text layout (Sturm et al. 2012): depth.txt, rgb.txt, groundtruth.txt; also ICL-NUIM in this form.
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>

#include "acquire/parse/timed_poses.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDepthList = "depth.txt";
constexpr const char* kColourList = "rgb.txt";
constexpr const char* kPoseList = "groundtruth.txt";
constexpr double kTumDepthScale = 5000.0;  // the layout's own: 0.2 mm
constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

struct Stamp {
  std::int64_t time_ns = 0;
  std::size_t index = 0;
};

struct NamedFile {
  std::int64_t time_ns = 0;
  std::string name;  // empty: the line names none
  std::size_t line = 0;
};

Error line_error(const fs::path& path, std::size_t line, std::string message) {
  return {ErrorCode::kInput, std::move(message), path.string() + ":" + std::to_string(line)};
}

Result<std::vector<NamedFile>> read_list(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::vector<NamedFile> files;
  for (const TextLine& line : text_lines(*text)) {
    const auto time = parse_seconds_ns(line.words[0]);
    if (!time) return line_error(path, line.number, "expected 'seconds file-name'");
    files.push_back({*time, line.words.size() > 1 ? std::string(line.words[1]) : std::string(), line.number});
  }
  return files;
}

std::vector<Stamp> sorted_stamps(const std::vector<NamedFile>& files) {
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < files.size(); ++i) stamps.push_back({files[i].time_ns, i});
  std::stable_sort(stamps.begin(), stamps.end(), [](const Stamp& a, const Stamp& b) { return a.time_ns < b.time_ns; });
  return stamps;
}

// The place of the stamp nearest to `time_ns` (the earlier of two equally near), or kNowhere.
std::size_t nearest(const std::vector<Stamp>& sorted, std::int64_t time_ns) {
  if (sorted.empty()) return kNowhere;
  const auto after = std::lower_bound(sorted.begin(), sorted.end(), time_ns,
                                      [](const Stamp& stamp, std::int64_t time) { return stamp.time_ns < time; });
  auto best = after == sorted.end() ? std::prev(after) : after;
  if (after != sorted.begin() &&
      distance_ns(std::prev(after)->time_ns, time_ns) <= distance_ns(best->time_ns, time_ns)) {
    best = std::prev(after);
  }
  return static_cast<std::size_t>(best - sorted.begin());
}

// For each depth picture the colour picture that is its nearest and whose nearest it is, within 20 ms: one to one.
std::vector<std::size_t> associate(const std::vector<NamedFile>& depth, const std::vector<NamedFile>& colour) {
  const auto depth_stamps = sorted_stamps(depth);
  const auto colour_stamps = sorted_stamps(colour);
  std::vector<std::size_t> partner(depth.size(), kNowhere);
  for (std::size_t i = 0; i < depth_stamps.size(); ++i) {
    const std::size_t place = nearest(colour_stamps, depth_stamps[i].time_ns);
    if (place == kNowhere) continue;
    const Stamp& match = colour_stamps[place];
    const bool is_mutual = nearest(depth_stamps, match.time_ns) == i;
    if (is_mutual && distance_ns(match.time_ns, depth_stamps[i].time_ns) <= kMaxDifference_ns) {
      partner[depth_stamps[i].index] = match.index;
    }
  }
  return partner;
}

// The path of `file`, or the fault that drops its frame.
void place_file(const fs::path& list, const NamedFile& file, SharedPath FrameEntry::*member, FrameEntry& entry) {
  auto path = resolve_inside(list.parent_path(), file.name);
  if (auto* drop = std::get_if<Drop>(&path)) {
    drop->error.where = list.string() + ":" + std::to_string(file.line);
    if (!entry.fault) entry.fault = std::move(*drop);
  } else {
    entry.*member = std::get<fs::path>(std::move(path));
  }
}

}  // namespace

bool fits_tum(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kDepthList)) return false;
  const auto text = read_text_file(folder.path / kDepthList, limits.max_text_bytes);
  if (!text) return false;
  const auto lines = text_lines(*text);
  return !lines.empty() && lines[0].words.size() >= 2 && parse_seconds_ns(lines[0].words[0]).has_value();
}

Result<Recording> index_tum(const Folder& folder, const AcquireConfig& config) {
  const fs::path depth_list = folder.path / kDepthList;
  const fs::path colour_list = folder.path / kColourList;
  const auto depth = read_list(depth_list, config.limits);
  if (!depth) return depth.error();
  std::vector<NamedFile> colour;
  if (folder.has_file(kColourList)) {
    auto list = read_list(colour_list, config.limits);
    if (!list) return list.error();
    colour = *std::move(list);
  }
  std::vector<TimedPose> poses;
  if (folder.has_file(kPoseList)) {
    auto list = read_tum_poses(folder.path / kPoseList, config.limits);
    if (!list) return list.error();
    poses = *std::move(list);
  }

  const auto depth_scale = find_depth_scale(folder.path, config.limits);
  if (!depth_scale) return depth_scale.error();
  Recording recording{.format = "tum", .folder = folder.path, .depth_scale = depth_scale->value_or(kTumDepthScale)};
  recording.decode = decode_png_frame;
  const auto partner = associate(*depth, colour);
  for (std::size_t i = 0; i < depth->size(); ++i) {
    FrameEntry entry{.sequence = i, .timestamp_ns = (*depth)[i].time_ns};
    place_file(depth_list, (*depth)[i], &FrameEntry::depth, entry);
    if (partner[i] != kNowhere) place_file(colour_list, colour[partner[i]], &FrameEntry::colour, entry);
    entry.T_world_camera = pose_at(poses, (*depth)[i].time_ns);
    recording.entries.push_back(std::move(entry));
  }
  const auto camera = find_camera(folder.path, config.limits);
  if (!camera) return camera.error();
  recording.camera = *camera;
  return recording;
}

}  // namespace scanknit
