// A folder of this process alone that lives until its end; in memory where the system has such a place.
#pragma once

#include <stdlib.h>  // mkdtemp

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace scanknit {

/// Ends the program, which a fuzzer and a replay take for a finding.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

class ScratchFolder {
 public:
  ScratchFolder() {
    const char* chosen = std::getenv("TMPDIR");
    std::error_code code;
    const bool has_memory = std::filesystem::is_directory("/dev/shm", code);
    std::string name = std::string(chosen != nullptr ? chosen : has_memory ? "/dev/shm" : "/tmp") + "/fuzz.XXXXXX";
    require(mkdtemp(name.data()) != nullptr, "a folder can be made in TMPDIR");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code code;
    std::filesystem::remove_all(path_, code);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Makes the folders above it, too.
inline void write_whole(const std::filesystem::path& path, std::string_view content) {
  std::error_code code;
  std::filesystem::create_directories(path.parent_path(), code);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  require(file.good(), "the scratch folder can be written");
}

}  // namespace scanknit
