#include "scan/scan_job.h"

#include "core/files/atomic_file.h"
#include "export/mesh/write_mesh.h"
#include "export/tiles/write_tiles.h"

namespace scanknit {

std::vector<std::filesystem::path> all_paths(const ScanFiles& files) {
  std::vector<std::filesystem::path> paths = files.meshes;
  for (const auto& path : {files.preview, files.error, files.coverage, files.trajectory, files.volume}) {
    if (path) paths.push_back(*path);
  }
  return paths;
}

std::optional<std::filesystem::path> uncertainty_picture(const ScanJob& job) {
  if (!job.config.output.uncertainty || job.files.meshes.empty()) return std::nullopt;
  const std::filesystem::path& mesh = job.files.meshes.front();
  return mesh.parent_path() / (mesh.stem().string() + "_uncertainty.png");
}

Result<void> check_files(const ScanJob& job) {
  std::vector<std::filesystem::path> own = all_paths(job.files);
  if (const auto picture = uncertainty_picture(job)) own.push_back(*picture);
  for (const auto& paths : {own, job.files_of_caller}) {
    for (const std::filesystem::path& path : paths) {
      const bool is_folder = is_tiles_path(path);
      if (auto writable = is_folder ? check_tiles_writable(path) : check_writable(path); !writable) return writable;
    }
  }
  return {};
}

}  // namespace scanknit
