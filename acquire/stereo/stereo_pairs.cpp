#include "acquire/stereo/stereo_pairs.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "acquire/parse/pose_list.h"
#include "acquire/parse/timed_poses.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPairTimes = "times.txt";
constexpr const char* kPairPoses = "trajectory.txt";

/// In natural order of their names.
Result<std::vector<fs::path>> list_side(const fs::path& folder, const Limits& limits) {
  const auto listing = list_folder(folder, limits);
  if (!listing) return listing.error();
  std::vector<fs::path> pictures;
  for (const std::string& name : listing->files) {
    const std::string ending = lower_case(fs::path(name).extension().string());
    if (ending == ".png" || ending == ".jpg" || ending == ".jpeg") pictures.push_back(folder / name);
  }
  return pictures;
}

Result<std::vector<FrameEntry>> pair_up(const StereoFolders& folders, const Limits& limits) {
  const auto left = list_side(folders.left, limits);
  if (!left) return left.error();
  const auto right = list_side(folders.right, limits);
  if (!right) return right.error();
  std::map<std::string, fs::path> right_by_stem;
  for (const fs::path& path : *right) right_by_stem.emplace(path.stem().string(), path);
  std::vector<FrameEntry> entries;
  bool agrees = false;
  for (const fs::path& path : *left) {
    const auto partner = right_by_stem.find(path.stem().string());
    FrameEntry entry{.sequence = entries.size(), .depth = folders.right / path.filename(), .colour = path};
    if (partner != right_by_stem.end()) {
      entry.depth = partner->second;
      agrees = true;
    } else {
      entry.fault = make_drop(DropReason::kMissingFile, "the right picture of this pair is missing", entry.depth);
    }
    entries.push_back(std::move(entry));
  }
  if (agrees) return entries;
  if (left->size() != right->size()) {
    return Error{ErrorCode::kInput,
                 std::to_string(left->size()) + " left pictures and " + std::to_string(right->size()) +
                     " right ones, and no name agrees: which make a pair is unknown. Give both of a pair one name",
                 folders.recording.path.string()};
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i].depth = (*right)[i];
    entries[i].fault.reset();
  }
  return entries;
}

/// Frame numbers that ascend; or times: nanoseconds, as EuRoC's names have them, or seconds with a point.
void take_names(std::vector<FrameEntry>& entries) {
  constexpr std::uint64_t kFirstTime = 1'000'000'000'000'000;  // as nanoseconds, 12 days after 1970
  std::vector<std::uint64_t> numbers;
  for (const FrameEntry& entry : entries) {
    const auto number = numbered_name(entry.colour->stem().string(), "", "");
    if (!number || (!numbers.empty() && *number <= numbers.back())) break;
    numbers.push_back(*number);
  }
  if (numbers.size() == entries.size() && !numbers.empty()) {
    const bool are_times = numbers.front() >= kFirstTime && numbers.back() <= (std::uint64_t{1} << 62);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (are_times) {
        entries[i].timestamp_ns = static_cast<std::int64_t>(numbers[i]);
      } else {
        entries[i].sequence = numbers[i];
      }
    }
    return;
  }
  std::vector<std::int64_t> times_ns;
  for (const FrameEntry& entry : entries) {
    const std::string stem = entry.colour->stem().string();
    const auto time = stem.find('.') != std::string::npos ? parse_seconds_ns(stem) : std::nullopt;
    if (!time) return;
    times_ns.push_back(*time);
  }
  for (std::size_t i = 0; i < entries.size(); ++i) entries[i].timestamp_ns = times_ns[i];
}

/// One "seconds" a line and pair.
Result<void> read_pair_times(const fs::path& path, const Limits& limits, std::vector<FrameEntry>& entries) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  const auto lines = text_lines(*text);
  if (lines.size() < entries.size()) {
    return Error{ErrorCode::kInput,
                 std::to_string(lines.size()) + " times for " + std::to_string(entries.size()) +
                     " left pictures; expected one a line for each",
                 path.string()};
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i].timestamp_ns = parse_seconds_ns(lines[i].words[0]);
    if (!entries[i].timestamp_ns) {
      return Error{ErrorCode::kInput, "expected a time in seconds",
                   path.string() + ":" + std::to_string(lines[i].number)};
    }
  }
  return {};
}

/// TUM's format: the recording's seconds, or the frame's number where it has none.
Result<void> read_pair_poses(const fs::path& path, const Limits& limits, std::vector<FrameEntry>& entries) {
  auto poses = read_tum_poses(path, limits);
  if (!poses) return poses.error();
  const bool has_clock = std::all_of(entries.begin(), entries.end(),
                                     [](const FrameEntry& entry) { return entry.timestamp_ns.has_value(); });
  if (has_clock) {
    for (FrameEntry& entry : entries) entry.T_world_camera = pose_at(*poses, *entry.timestamp_ns);
    return {};
  }
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  std::map<std::uint64_t, FrameEntry*> by_number;
  for (FrameEntry& entry : entries) by_number.emplace(entry.sequence, &entry);
  for (TimedPose& pose : *poses) {
    if (pose.time_ns < 0 || pose.time_ns % kSecond_ns != 0) continue;
    const auto entry = by_number.find(static_cast<std::uint64_t>(pose.time_ns / kSecond_ns));
    if (entry != by_number.end()) entry->second->T_world_camera = std::move(pose.pose);
  }
  return {};
}

}  // namespace

Result<std::vector<FrameEntry>> list_stereo_pairs(const StereoFolders& folders, const Limits& limits) {
  auto entries = pair_up(folders, limits);
  if (!entries) return entries;
  take_names(*entries);
  const Folder& folder = folders.recording;
  if (folder.has_file(kPairTimes)) {
    if (const auto read = read_pair_times(folder.path / kPairTimes, limits, *entries); !read) return read.error();
  }
  if (folder.has_file(kPairPoses)) {
    if (const auto read = read_pair_poses(folder.path / kPairPoses, limits, *entries); !read) return read.error();
    return entries;
  }
  const auto poses = read_pose_list(folder, limits);
  if (!poses) return poses.error();
  for (std::size_t i = 0; i < std::min(entries->size(), poses->size()); ++i) {
    (*entries)[i].T_world_camera = (*poses)[i];
  }
  return entries;
}

}  // namespace scanknit
