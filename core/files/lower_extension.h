// lower_extension(): a file's ending, for people who write it in capitals.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace scanknit {

/// ".ply" of "bunny.PLY". ASCII letters only.
[[nodiscard]] inline std::string lower_extension(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace scanknit
