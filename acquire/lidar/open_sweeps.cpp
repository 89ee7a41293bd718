#include "acquire/lidar/bag_sweeps.h"
#include "acquire/lidar/kitti.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/recording_format.h"
#include "acquire/replay/raw_recording.h"

namespace scanknit {

bool is_sweep_recording(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.format != RecordingFormat::kAuto || config.geometry == Geometry::kStereo) return false;
  std::error_code code;
  if (config.format == RecordingFormat::kAuto && std::filesystem::is_directory(path, code)) {
    const auto folder = list_folder(path, config.limits);
    if (folder && fits_kitti(*folder, config.limits)) return true;
  }
  return fits_bag_sweeps(path, config);
}

Result<std::unique_ptr<SweepSource>> open_sweeps(const std::filesystem::path& path, const AcquireConfig& config) {
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) {
    const auto folder = list_folder(path, config.limits);
    if (!folder) return folder.error();
    if (fits_kitti(*folder, config.limits)) return open_kitti(*folder, config.limits);
  }
  if (find_bag(path, config)) return open_bag_sweeps(path, config);
  return Error{ErrorCode::kInput,
               "no recording of LiDAR sweeps; looked for velodyne/000000.bin (KITTI odometry) and bags of ROS",
               path.string()};
}

}  // namespace scanknit
