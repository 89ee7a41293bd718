#include "acquire/lidar/kitti.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/recording_format.h"

namespace scanknit {

bool is_sweep_recording(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.format != RecordingFormat::kAuto || config.geometry == Geometry::kStereo) return false;
  std::error_code code;
  if (!std::filesystem::is_directory(path, code)) return false;
  const auto folder = list_folder(path, config.limits);
  return folder && fits_kitti(*folder, config.limits);
}

Result<std::unique_ptr<SweepSource>> open_sweeps(const std::filesystem::path& path, const AcquireConfig& config) {
  const auto folder = list_folder(path, config.limits);
  if (!folder) return folder.error();
  if (fits_kitti(*folder, config.limits)) return open_kitti(*folder, config.limits);
  return Error{ErrorCode::kInput, "no recording of LiDAR sweeps; looked for velodyne/000000.bin (KITTI odometry)",
               path.string()};
}

}  // namespace scanknit
