#include "core/system/machine_memory.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// What a file of the kernel's says, which has no size; nothing if it cannot be read.
std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(1 << 16, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return text;
}

/// The number that the text begins with; nothing for "max" and "unlimited".
std::optional<std::uint64_t> first_number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return parse_number<std::uint64_t>(text.substr(0, text.find_first_not_of("0123456789")));
}

/// The number behind `name` at the begin of a line.
std::optional<std::uint64_t> number_after(const std::string& text, std::string_view name) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(name)) return first_number(std::string_view(line).substr(name.size()));
  }
  return std::nullopt;
}

/// The least limit of the group at `path` below `root` and of those round it.
std::optional<std::uint64_t> group_limit(const fs::path& root, fs::path path, const char* file) {
  // A path with ".." is outside of what the container sees; its own group is then the root.
  if (std::find(path.begin(), path.end(), "..") != path.end()) path.clear();
  std::optional<std::uint64_t> least;
  for (path = path.relative_path();; path = path.parent_path()) {
    if (const auto limit = first_number(text_of(root / path / file))) {
      least = std::min(*limit, least.value_or(*limit));
    }
    if (path.empty()) return least;
  }
}

/// The least limit of the groups that /proc/self/cgroup names: "NUMBER:CONTROLLERS:PATH", of version 2 "0::PATH".
std::optional<std::uint64_t> least_group_limit(const std::string& groups, const fs::path& root) {
  std::optional<std::uint64_t> least;
  std::istringstream lines(groups);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path path = line.substr(second + 1);
    std::optional<std::uint64_t> limit;
    if (controllers == ",,") limit = group_limit(root, path, "memory.max");
    if (controllers.find(",memory,") != std::string::npos) {
      limit = group_limit(root / "memory", path, "memory.limit_in_bytes");
    }
    if (limit) least = std::min(*limit, least.value_or(*limit));
  }
  return least;
}

}  // namespace

std::optional<std::size_t> machine_memory_mib(const KernelFolders& folders) {
  constexpr std::uint64_t kKibibyte = 1024, kMebibyte = 1024 * 1024;
  const fs::path& processes = folders.processes;
  const auto machine_kib = number_after(text_of(processes / "meminfo"), "MemTotal:");
  if (!machine_kib) return std::nullopt;
  std::uint64_t least = *machine_kib * kKibibyte;
  if (const auto limit = least_group_limit(text_of(processes / "self/cgroup"), folders.groups)) {
    least = std::min(least, *limit);
  }
  if (const auto limit = number_after(text_of(processes / "self/limits"), "Max address space")) {
    least = std::min(least, *limit);
  }
  return static_cast<std::size_t>(least / kMebibyte);
}

std::size_t default_memory_budget_mib(std::optional<std::size_t> machine_mib) {
  constexpr std::size_t kLeast = 128, kMost = 4096;
  return machine_mib ? std::clamp(*machine_mib / 2, kLeast, kMost) : kMost;
}

}  // namespace scanknit
