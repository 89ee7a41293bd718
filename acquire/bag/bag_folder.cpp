// A bag of ROS 2 in several files: by its metadata.yaml, else NAME_0.mcap, NAME_1.mcap ... in the order of their
// numbers.
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/bag_metadata.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/numbered_name.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";
constexpr std::array kBagEnds = {".mcap", ".db3", ".mcap.zstd", ".db3.zstd"};

std::vector<std::string> listed_parts(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kMetadata)) return {};
  const auto yaml = read_text_file(folder.path / kMetadata, limits.max_text_bytes);
  if (!yaml || !is_bag_metadata(*yaml)) return {};
  return files_of_bag(*yaml);
}

bool is_bag_at(const fs::path& path) {
  const auto file = open_random_access(path);
  return file && is_bag_file(**file);
}

/// The files of the only name in the folder that has numbers, with gaps where numbers are missing; empty: there is no
/// such name, or more than one, or a single file.
std::vector<std::string> numbered_parts(const Folder& folder) {
  std::map<std::string, std::vector<std::uint64_t>> numbers;  // by "NAME_*.mcap"
  for (const std::string& name : folder.files) {
    const auto end = std::find_if(kBagEnds.begin(), kBagEnds.end(), [&](const char* e) { return name.ends_with(e); });
    const auto underscore = name.rfind('_');
    if (end == kBagEnds.end() || underscore == std::string::npos) continue;
    const std::string stem = name.substr(0, underscore + 1);
    if (const auto number = numbered_name(name, stem, *end)) numbers[stem + "*" + *end].push_back(*number);
  }
  if (numbers.size() != 1 || numbers.begin()->second.size() < 2) return {};
  const std::string& pattern = numbers.begin()->first;
  auto& found = numbers.begin()->second;
  std::sort(found.begin(), found.end());
  constexpr std::uint64_t kMostMissing = 1000;
  const auto star = pattern.find('*');
  std::vector<std::string> names;
  const auto name_of = [&](std::uint64_t number) {
    return pattern.substr(0, star) + std::to_string(number) + pattern.substr(star + 1);
  };
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::uint64_t gap = i > 0 ? found[i] - found[i - 1] : 1;
    for (std::uint64_t k = 1; k < gap && gap <= kMostMissing; ++k) names.push_back(name_of(found[i - 1] + k));
    names.push_back(name_of(found[i]));
  }
  if (!folder.has_file(names.front()) || !is_bag_at(folder.path / names.front())) return {};
  return names;
}

/// Early versions of rosbag2 wrote the folder's own name in front.
Result<fs::path> part_path(const Folder& folder, const std::string& name) {
  auto path = resolve_inside(folder.path, name);
  if (auto* drop = std::get_if<Drop>(&path)) return std::move(drop->error);
  const fs::path inside = fs::path(name).filename();
  std::error_code code;
  const bool is_elsewhere = !fs::exists(std::get<fs::path>(path), code) && folder.has_file(inside.string());
  return is_elsewhere ? folder.path / inside : std::get<fs::path>(path);
}

Result<std::unique_ptr<BagMessages>> open_part(const Folder& folder, const std::string& name, const Limits& limits) {
  const auto path = part_path(folder, name);
  if (!path) return path.error();
  std::error_code code;
  if (!fs::exists(*path, code)) return Error{ErrorCode::kInput, "it is not there", path->string()};
  auto file = open_random_access(*path);
  if (!file) return file.error();
  auto messages = open_bag_file(*std::move(file), *path, limits);
  return messages ? std::move(messages) : located(messages.error(), *path);
}

std::vector<std::string> parts_of(const Folder& folder, const Limits& limits) {
  auto parts = listed_parts(folder, limits);
  return parts.empty() ? numbered_parts(folder) : parts;
}

}  // namespace

bool fits_split_bag(const Folder& folder, const Limits& limits) {
  return parts_of(folder, limits).size() > 1;
}

Result<OpenBag> open_split_bag(const Folder& folder, const Limits& limits) {
  OpenBag bag;
  std::vector<std::unique_ptr<BagMessages>> parts;
  std::optional<Error> first_fault;
  for (const std::string& name : parts_of(folder, limits)) {
    auto part = open_part(folder, name, limits);
    if (part) {
      parts.push_back(*std::move(part));
      continue;
    }
    bag.warnings.push_back("the bag's part '" + name + "' is left out, with its frames: " + part.error().message);
    if (!first_fault) first_fault = part.error();
  }
  if (parts.empty()) {
    return first_fault.value_or(Error{ErrorCode::kInput, "no part of a bag is there", folder.path.string()});
  }
  auto messages = join_messages(std::move(parts), limits);
  if (!messages) return located(messages.error(), folder.path);
  bag.messages = *std::move(messages);
  return bag;
}

Result<Recording> index_split_bag(const Folder& folder, const AcquireConfig& config) {
  auto bag = open_split_bag(folder, config.limits);
  if (!bag) return bag.error();
  auto recording = index_bag(std::move(bag->messages), folder.path, config);
  if (!recording) return recording;
  recording->warnings.insert(recording->warnings.begin(), bag->warnings.begin(), bag->warnings.end());
  return recording;
}

}  // namespace scanknit
