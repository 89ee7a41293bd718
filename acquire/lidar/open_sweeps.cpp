#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquire/lidar/bag_sweeps.h"
#include "acquire/lidar/kitti.h"
#include "acquire/lidar/pcap_file.h"
#include "acquire/lidar/pcap_sweeps.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/recording_format.h"
#include "acquire/replay/folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Sequences of KITTI's: the folder itself, or the one that its `velodyne` belongs to; else those below it, or below
/// its `sequences`, as the benchmark has them.
std::vector<fs::path> kitti_sequences(const fs::path& path, const Limits& limits) {
  const auto fits = [&](const fs::path& at) {
    std::error_code code;
    if (!fs::is_directory(at / "velodyne", code)) return false;
    const auto folder = list_folder(at, limits);
    return folder && fits_kitti(*folder, limits);
  };
  if (fits(path)) return {path};
  const fs::path named = path.has_filename() ? path : path.parent_path();
  if (named.filename() == "velodyne") {
    const fs::path parent = named.has_parent_path() ? named.parent_path() : fs::path("..");
    if (fits(parent)) return {parent};
  }
  std::vector<fs::path> found;
  for (const fs::path& base : {path, path / "sequences"}) {
    const auto folder = list_folder(base, limits);
    if (!folder) continue;
    for (const std::string& name : folder->folders) {
      if (fits(base / name)) found.push_back(base / name);
    }
  }
  return found;
}

/// The capture itself, or the only one in a folder that holds nothing else but what belongs to it.
std::optional<fs::path> find_capture(const fs::path& path, const Limits& limits) {
  if (is_pcap_file(path)) return path;
  const auto folder = list_folder(path, limits);
  if (!folder || !folder->folders.empty()) return std::nullopt;
  std::optional<fs::path> capture;
  for (const std::string& name : folder->files) {
    const fs::path end = fs::path(name).extension();
    const bool is_beside = end == ".json" || end == ".tum" || end == ".txt" || end == ".md";
    if (is_beside) continue;
    if (capture || !is_pcap_file(path / name)) return std::nullopt;
    capture = path / name;
  }
  return capture;
}

Error several_sequences(const fs::path& path, const std::vector<fs::path>& found) {
  std::string message = "holds " + std::to_string(found.size()) + " sequences of LiDAR sweeps; name one of them:";
  for (const fs::path& sequence : found) message += "\n  " + sequence.string();
  return {ErrorCode::kInput, message, path.string()};
}

}  // namespace

bool is_sweep_recording(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.geometry == Geometry::kStereo) return false;
  const bool has_any_format = config.format == RecordingFormat::kAuto;
  if (has_any_format && (find_capture(path, config.limits) || !kitti_sequences(path, config.limits).empty()))
    return true;
  return fits_bag_sweeps(path, config);
}

Result<std::unique_ptr<SweepSource>> open_sweeps(const std::filesystem::path& path, const AcquireConfig& config) {
  if (config.camera) {
    return Error{ErrorCode::kConfig, "acquire.camera: LiDAR sweeps are seen by no camera; leave it at auto",
                 config.camera->file};
  }
  if (const auto capture = find_capture(path, config.limits)) return open_pcap_sweeps(*capture, config.limits);
  const auto kitti = kitti_sequences(path, config.limits);
  if (kitti.size() > 1) return several_sequences(path, kitti);
  if (!kitti.empty()) {
    const auto folder = list_folder(kitti.front(), config.limits);
    return folder ? open_kitti(*folder, config.limits) : folder.error();
  }
  if (find_bag(path, config)) return open_bag_sweeps(path, config);
  return Error{ErrorCode::kInput,
               "no recording of LiDAR sweeps; looked for velodyne/000000.bin (KITTI odometry), a bag of ROS, and a "
               "capture .pcap of a Velodyne or an Ouster",
               path.string()};
}

}  // namespace scanknit
