#include "scan/scan_job.h"

#include "core/files/atomic_file.h"

namespace scanknit {

std::vector<std::filesystem::path> all_paths(const ScanFiles& files) {
  std::vector<std::filesystem::path> paths = files.meshes;
  for (const auto& path : {files.preview, files.error, files.coverage, files.trajectory, files.volume}) {
    if (path) paths.push_back(*path);
  }
  return paths;
}

Result<void> check_files(const ScanJob& job) {
  for (const auto& paths : {all_paths(job.files), job.files_of_caller}) {
    for (const std::filesystem::path& path : paths) {
      if (auto writable = check_writable(path); !writable) return writable;
    }
  }
  return {};
}

}  // namespace scanknit
