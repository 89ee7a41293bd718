#include "acquire/replay/folder.h"

#include <algorithm>
#include <cctype>
#include <system_error>
#include <utility>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

// Five files a frame (depth, confidence, colour, pose, camera) is the most that a layout has.
constexpr std::size_t kMaxFilesPerFrame = 5;

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::binary_search(names.begin(), names.end(), name, natural_less);
}

// The run of digits at the front of `text`, without leading zeros.
std::string_view number_at_front(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::size_t begin = 0;
  while (begin + 1 < end && text[begin] == '0') ++begin;
  return text.substr(begin, end - begin);
}

std::size_t digits_at_front(std::string_view text) {
  return static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
}

}  // namespace

bool Folder::has_file(std::string_view name) const {
  return contains(files, name);
}
bool Folder::has_folder(std::string_view name) const {
  return contains(folders, name);
}

bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view number_a = number_at_front(a);
      const std::string_view number_b = number_at_front(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
      a.remove_prefix(digits_at_front(a));
      b.remove_prefix(digits_at_front(b));
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // "01" and "1" are equal as numbers
}

Result<Folder> list_folder(const fs::path& path, const Limits& limits) {
  Folder folder{path, {}, {}};
  std::error_code code;
  fs::directory_iterator entry(path, code);
  if (code) return Error{ErrorCode::kInput, code.message(), path.string()};
  for (; entry != fs::directory_iterator(); entry.increment(code)) {
    std::string name = entry->path().filename().string();
    if (name.starts_with('.')) continue;
    std::error_code status_code;
    const auto kind = entry->status(status_code).type();
    // A dangling symbolic link stays in the list: its frame is then dropped with a reason instead of vanishing.
    (kind == fs::file_type::directory ? folder.folders : folder.files).push_back(std::move(name));
    if (folder.files.size() + folder.folders.size() > kMaxFilesPerFrame * limits.max_frames) {
      return Error{ErrorCode::kInput, "more files than a recording may have", path.string()};
    }
    if (code) break;
  }
  if (code) return Error{ErrorCode::kInput, code.message(), path.string()};
  std::sort(folder.files.begin(), folder.files.end(), natural_less);
  std::sort(folder.folders.begin(), folder.folders.end(), natural_less);
  return folder;
}

OrDrop<fs::path> resolve_inside(const fs::path& folder, std::string_view name) {
  const fs::path relative(name);
  const auto refuse = [&](const char* what) {
    return make_drop(DropReason::kUnsafePath, std::string("the recording names '") + relative.string() + "', " + what,
                     folder);
  };
  if (name.empty() || name.find('\0') != std::string_view::npos) return refuse("which is not a file name");
  if (relative.is_absolute()) return refuse("an absolute path; only files inside the recording's folder are read");
  if (std::find(relative.begin(), relative.end(), fs::path("..")) != relative.end()) {
    return refuse("a path that climbs with '..'; only files inside the recording's folder are read");
  }
  std::error_code code;
  const fs::path root = fs::canonical(folder, code);
  if (code) return refuse("in a folder that cannot be resolved");
  const fs::path target = fs::weakly_canonical(root / relative, code);
  if (code) return refuse("which cannot be resolved");
  const auto [root_end, unused] = std::mismatch(root.begin(), root.end(), target.begin(), target.end());
  if (root_end != root.end()) return refuse("a symbolic link out of the recording's folder");
  return folder / relative;
}

}  // namespace scanknit
