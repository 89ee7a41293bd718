#include "acquire/lidar/bag_sweeps.h"
#include "acquire/lidar/kitti.h"
#include "acquire/lidar/pcap_file.h"
#include "acquire/lidar/pcap_sweeps.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/recording_format.h"
#include "acquire/replay/raw_recording.h"

namespace scanknit {
namespace {

bool is_kitti(const std::filesystem::path& path, const Limits& limits) {
  std::error_code code;
  if (!std::filesystem::is_directory(path, code)) return false;
  const auto folder = list_folder(path, limits);
  return folder && fits_kitti(*folder, limits);
}

}  // namespace

bool is_sweep_recording(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.geometry == Geometry::kStereo) return false;
  const bool has_any_format = config.format == RecordingFormat::kAuto;
  if (has_any_format && (is_kitti(path, config.limits) || is_pcap_file(path))) return true;
  return fits_bag_sweeps(path, config);
}

Result<std::unique_ptr<SweepSource>> open_sweeps(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.camera) {
    return Error{ErrorCode::kConfig, "acquire.camera: LiDAR sweeps are seen by no camera; leave it at auto",
                 config.camera->file};
  }
  if (is_pcap_file(path)) return open_pcap_sweeps(path, config.limits);
  if (is_kitti(path, config.limits)) {
    const auto folder = list_folder(path, config.limits);
    return folder ? open_kitti(*folder, config.limits) : folder.error();
  }
  if (find_bag(path, config)) return open_bag_sweeps(path, config);
  return Error{ErrorCode::kInput,
               "no recording of LiDAR sweeps; looked for velodyne/000000.bin (KITTI odometry), a bag of ROS, and a "
               "capture .pcap of a Velodyne or an Ouster",
               path.string()};
}

}  // namespace scanknit
