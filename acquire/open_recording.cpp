#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "acquire/frame_source.h"
#include "acquire/masks/found_masks.h"
#include "acquire/masks/mask_files.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/recording_format.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/folder.h"
#include "acquire/replay/indexed_source.h"
#include "acquire/replay/layouts.h"
#include "acquire/sensor/recognise_sensor.h"
#include "acquire/sensor/scanner_camera.h"
#include "acquire/sensor/sensor_profile.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

struct Layout {
  RecordingFormat format;
  const char* name;
  const char* content;
  bool (*fits)(const Folder&, const Limits&);
  Result<Recording> (*index)(const Folder&, const AcquireConfig&);
};

// Asked in this order; the first that fits is taken. Some would fit `open3d`, too, which asks for less, and come first.
constexpr std::array kLayouts = {
    Layout{RecordingFormat::kSevenScenes, "7-scenes", "frame-000000.depth.png with .color.png and .pose.txt",
           fits_seven_scenes, index_seven_scenes},
    Layout{RecordingFormat::kPhoneLidar, "phone-lidar", "depth_00000.png with frame_00000.json", fits_phone_lidar,
           index_phone_lidar},
    Layout{RecordingFormat::kStrayScanner, "stray-scanner", "odometry.csv with depth/000000.png and camera_matrix.csv",
           fits_stray_scanner, index_stray_scanner},
    Layout{RecordingFormat::kArkitscenes, "arkitscenes",
           "lowres_depth/ID_TIME.png with lowres_wide.traj and lowres_wide_intrinsics/", fits_arkitscenes,
           index_arkitscenes},
    Layout{RecordingFormat::kPolycam, "polycam", "keyframes/ with depth/ and corrected_cameras/ or cameras/",
           fits_polycam, index_polycam},
    Layout{RecordingFormat::kReplica, "replica", "traj.txt with results/depth000000.png", fits_replica, index_replica},
    Layout{RecordingFormat::kBop, "bop", "scene_camera.json with depth/000000.png", fits_bop, index_bop},
    Layout{RecordingFormat::kTum, "tum", "depth.txt with rgb.txt and groundtruth.txt", fits_tum, index_tum},
    Layout{RecordingFormat::kNerfstudio, "nerfstudio", "transforms.json whose frames have a depth_file_path",
           fits_nerfstudio, index_nerfstudio},
    Layout{RecordingFormat::kOpen3d, "open3d", "depth/ with color/ or image/, camera_intrinsic.json, trajectory.log",
           fits_open3d, index_open3d},
    Layout{RecordingFormat::kFakenect, "fakenect", "INDEX.txt with d-*.pgm and r-*.ppm", fits_fakenect, index_fakenect},
    Layout{RecordingFormat::kPclzf, "pclzf", "NAME_depth.pclzf with NAME.xml", fits_pclzf, index_pclzf},
    Layout{RecordingFormat::kRos2, "ros2", "a bag of ROS 2: metadata.yaml with several .mcap or .db3 files",
           fits_split_bag, index_split_bag},
    Layout{RecordingFormat::kPcd, "pcd", "organised point clouds *.pcd", fits_pcd, index_pcd},
};

struct FileLayout {
  RecordingFormat format;
  const char* name;
  const char* content;
  bool (*fits)(const RandomAccess&);
  Result<Recording> (*index)(std::unique_ptr<RandomAccess>, const fs::path&, const AcquireConfig&);
};

// Recordings that are one file.
constexpr std::array kFileLayouts = {
    FileLayout{RecordingFormat::kRos2, "ros2", "an .mcap or .db3 file of ROS 2 with depth pictures", fits_ros2,
               index_ros2},
    FileLayout{RecordingFormat::kMcap, "mcap", "an .mcap file of ScanKnit", fits_mcap, index_mcap},
    FileLayout{RecordingFormat::kRealsenseBag, "realsense-bag", "a .bag of RealSense Viewer", fits_realsense_bag,
               index_realsense_bag},
    FileLayout{RecordingFormat::kRos1, "ros1", "a .bag of ROS 1 with depth pictures", fits_ros1, index_ros1},
    FileLayout{RecordingFormat::kOni, "oni", "an .oni file of OpenNI 1 or 2", fits_oni, index_oni},
    FileLayout{RecordingFormat::kRecord3d, "record3d", "an .r3d file of Record3D", fits_record3d, index_record3d},
    FileLayout{RecordingFormat::kSens, "sens", "a .sens file of ScanNet", fits_sens, index_sens},
    FileLayout{RecordingFormat::kAzureMkv, "azure-mkv", "an .mkv file of Azure Kinect's recorder", fits_azure_mkv,
               index_azure_mkv},
};

constexpr int kLevelsBelow = 2;             // how deep a lone recording is searched for
constexpr std::size_t kMaxCandidates = 64;  // sub-folders looked into at each level

/// A folder of pictures, or one file.
struct Found {
  Folder folder;
  const Layout* layout = nullptr;
  fs::path file = {};
  const FileLayout* file_layout = nullptr;

  [[nodiscard]] fs::path path() const { return layout != nullptr ? folder.path : file; }
  [[nodiscard]] Result<Recording> index(const AcquireConfig& config) const {
    if (layout != nullptr) return layout->index(folder, config);
    auto access = open_random_access(file);
    if (!access) return access.error();
    return file_layout->index(*std::move(access), file, config);
  }
};

const Layout* layout_of(const Folder& folder, const AcquireConfig& config) {
  const auto match = std::find_if(kLayouts.begin(), kLayouts.end(), [&](const Layout& layout) {
    const bool is_wanted = config.format == RecordingFormat::kAuto || config.format == layout.format;
    return is_wanted && layout.fits(folder, config.limits);
  });
  return match == kLayouts.end() ? nullptr : &*match;
}

const FileLayout* layout_of(const RandomAccess& file, const AcquireConfig& config) {
  const auto match = std::find_if(kFileLayouts.begin(), kFileLayouts.end(), [&](const FileLayout& layout) {
    const bool is_wanted = config.format == RecordingFormat::kAuto || config.format == layout.format;
    return is_wanted && layout.fits(file);
  });
  return match == kFileLayouts.end() ? nullptr : &*match;
}

template <typename Ends>
bool ends_as_one_of(const Ends& ends, const std::string& name) {
  return std::any_of(ends.begin(), ends.end(), [&](const char* end) { return name.ends_with(end); });
}

// Recordings that are one file each, by the usual ends of their names.
std::vector<Found> find_file_recordings(const Folder& folder, const AcquireConfig& config) {
  constexpr std::array kEnds = {".mcap", ".db3", ".zstd", ".bag", ".oni", ".sens", ".r3d", ".mkv"};
  std::vector<Found> found;
  for (const std::string& name : folder.files) {
    if (!ends_as_one_of(kEnds, name)) continue;
    const auto file = open_random_access(folder.path / name);
    const FileLayout* layout = file ? layout_of(**file, config) : nullptr;
    if (layout != nullptr) found.push_back({.folder = {}, .file = folder.path / name, .file_layout = layout});
  }
  return found;
}

// The recordings at `path` itself, else those below it.
Result<std::vector<Found>> find_recordings(const fs::path& path, int levels, const AcquireConfig& config) {
  auto folder = list_folder(path, config.limits);
  if (!folder) return folder.error();
  std::vector<Found> found;
  if (const Layout* layout = layout_of(*folder, config)) {
    found.push_back({*std::move(folder), layout});
    return found;
  }
  found = find_file_recordings(*folder, config);
  if (levels == 0 || !found.empty()) return found;
  for (std::size_t i = 0; i < std::min(folder->folders.size(), kMaxCandidates); ++i) {
    auto below = find_recordings(path / folder->folders[i], levels - 1, config);
    if (!below) continue;  // a sub-folder that cannot be entered holds no recording for us
    std::move(below->begin(), below->end(), std::back_inserter(found));
  }
  return found;
}

std::string list_layouts(RecordingFormat wanted) {
  std::string text;
  const auto list = [&](const auto& layouts) {
    for (const auto& layout : layouts) {
      if (wanted != RecordingFormat::kAuto && wanted != layout.format) continue;
      text += std::string("\n  ") + layout.name + ": " + layout.content;
    }
  };
  list(kLayouts);
  list(kFileLayouts);
  if (wanted == RecordingFormat::kAuto) {
    text += "\n  sweeps of a LiDAR: velodyne/000000.bin (KITTI's odometry benchmark), a capture .pcap of its packets";
  }
  return text;
}

/// Whether a folder may be pictures for silhouettes: it has masks.
bool has_masks(const fs::path& path) {
  std::error_code code;
  return std::any_of(kMaskFolders.begin(), kMaskFolders.end(),
                     [&](const char* name) { return fs::is_directory(path / name, code); });
}

/// Sweeps of a LiDAR, which are no frames (acquire/lidar/sweep_source.h), by their names.
bool has_sweeps(const fs::path& path) {
  std::error_code code;
  const fs::path end = path.extension();
  return end == ".pcap" || end == ".pcapng" || fs::is_directory(path / "velodyne", code);
}

Error nothing_fits(const fs::path& path, const AcquireConfig& config) {
  std::string message = "no recording of a known layout; looked for" + list_layouts(config.format);
  if (has_stereo_pairs(path, config.limits)) {
    message += "\nIt has pairs of pictures: they become depth with acquire.geometry=stereo";
  }
  if (has_sweeps(path)) message += "\nIt has sweeps of a LiDAR: only run and info read them";
  if (has_masks(path)) {
    message += "\nIt has masks: pictures without depth become a mesh with acquire.geometry=silhouettes";
  }
  return {ErrorCode::kInput, message, path.string()};
}

Error several_fit(const fs::path& path, const std::vector<Found>& found) {
  constexpr std::size_t kShown = 5;
  std::string message = "holds " + std::to_string(found.size()) + " recordings; name one of them:";
  for (std::size_t i = 0; i < std::min(found.size(), kShown); ++i) message += "\n  " + found[i].path().string();
  if (found.size() > kShown) message += "\n  ...";
  return {ErrorCode::kInput, message, path.string()};
}

Result<Found> find_recording(const fs::path& path, int levels, const AcquireConfig& config) {
  auto found = find_recordings(path, levels, config);
  if (!found) return found.error();
  if (found->empty()) return nothing_fits(path, config);
  if (found->size() > 1) return several_fit(path, *found);
  return std::move(found->front());
}

// One file of a recording: a point cloud or PCLZF frame stands for itself, any other for the folder that it is a part
// of. Files beside it that are recordings are others.
Result<Found> find_by_file(const fs::path& file, const AcquireConfig& config) {
  const fs::path parent = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const std::string name = file.filename().string();
  const std::string extension = file.extension().string();
  if (extension != ".pcd" && extension != ".pclzf") {
    // A picture of the Open3D layout lies one folder down. What else lies up there is not asked for, nor whether it can
    // be listed.
    for (const fs::path& place : {parent, parent / ".."}) {
      auto folder = list_folder(place, config.limits);
      if (!folder && place == parent) return folder.error();
      const Layout* layout = folder ? layout_of(*folder, config) : nullptr;
      if (layout != nullptr) return Found{*std::move(folder), layout};
    }
    return nothing_fits(file, config);
  }
  Folder frame{parent, {name}, {}};
  if (extension == ".pclzf") {
    const std::string stem = name.substr(0, name.find_last_of('_'));
    frame.files.clear();
    std::error_code code;
    for (const char* suffix : {"_depth.pclzf", "_rgb.pclzf"}) {
      if (fs::exists(parent / (stem + suffix), code)) frame.files.push_back(stem + suffix);
    }
  }
  const Layout* layout = layout_of(frame, config);
  if (layout == nullptr) return nothing_fits(file, config);
  return Found{std::move(frame), layout};
}

Result<Recording> index_recording(const fs::path& path, const AcquireConfig& config) {
  std::error_code code;
  const auto kind = fs::status(path, code).type();
  if (kind == fs::file_type::not_found || kind == fs::file_type::none) {
    return Error{ErrorCode::kInput, "no such file or folder", path.string()};
  }
  const bool is_stereo = config.geometry == Geometry::kStereo;
  if (kind == fs::file_type::regular) {
    auto file = open_random_access(path);
    if (!file) return file.error();
    const FileLayout* layout = layout_of(**file, config);
    const bool may_hold = layout != nullptr && (!is_stereo || layout->format == RecordingFormat::kMcap);
    if (may_hold) return layout->index(*std::move(file), path, config);
  }
  if (is_stereo) return index_stereo(path, config);
  const auto found =
      kind == fs::file_type::directory ? find_recording(path, kLevelsBelow, config) : find_by_file(path, config);
  if (!found) return found.error();
  return found->index(config);
}

// What the configuration may say, whoever wrote it.
Result<void> check_config(const AcquireConfig& config) {
  const auto refuse = [](const char* what) { return Error{ErrorCode::kConfig, what}; };
  constexpr double kMinScale = 1.0;  // whole metres
  constexpr double kMaxScale = 1e7;  // a tenth of a micrometre
  if (config.depth_scale && !(*config.depth_scale >= kMinScale && *config.depth_scale <= kMaxScale)) {
    return refuse("acquire.depth_scale: expected raw units per metre, 1 to 10000000");
  }
  if (config.every == 0) return refuse("every: expected 1 or more");
  if (config.from > config.to) return refuse("from: expected no more than to");
  if (config.intrinsics) {
    CameraIntrinsics camera = config.intrinsics->intrinsics;
    if (camera.width == 0 && camera.height == 0) camera.width = camera.height = 1;
    const Distortion& d = config.intrinsics->distortion;
    const bool is_finite = std::all_of(d.begin(), d.end(), [](double k) { return std::isfinite(k); });
    if (!camera.is_valid() || !is_finite) {
      return refuse("acquire.intrinsics: expected finite numbers, fx and fy not 0, width and height both or neither");
    }
  }
  return check_cameras(config);
}

/// With the depth camera of acquire.camera as its intrinsics.
Result<AcquireConfig> settled(const AcquireConfig& config) {
  if (auto good = check_config(config); !good) return good.error();
  AcquireConfig result = config;
  if (config.camera && config.camera->depth) result.intrinsics = config.camera->depth;
  return result;
}

/// Layouts that may be bags of ROS.
bool is_of_bags(RecordingFormat format) {
  return format == RecordingFormat::kRos2 || format == RecordingFormat::kRos1 ||
         format == RecordingFormat::kRealsenseBag || format == RecordingFormat::kMcap;
}

}  // namespace

std::optional<fs::path> find_bag(const fs::path& path, const AcquireConfig& config) {
  std::error_code code;
  if (fs::is_regular_file(path, code)) {
    const auto file = open_random_access(path);
    const FileLayout* layout = file ? layout_of(**file, config) : nullptr;
    return layout != nullptr && is_of_bags(layout->format) ? std::optional(path) : std::nullopt;
  }
  constexpr std::array kEnds = {".mcap", ".db3", ".zstd", ".bag"};
  const auto folder = list_folder(path, config.limits);
  const auto is_bag_name = [&](const std::string& name) { return ends_as_one_of(kEnds, name); };
  if (!folder || std::none_of(folder->files.begin(), folder->files.end(), is_bag_name)) return std::nullopt;
  const auto found = find_recordings(path, 0, config);
  if (!found || found->size() != 1) return std::nullopt;
  const Found& bag = found->front();
  const RecordingFormat format = bag.layout != nullptr ? bag.layout->format : bag.file_layout->format;
  return is_of_bags(format) ? std::optional(bag.path()) : std::nullopt;
}

Result<std::unique_ptr<FrameSource>> open_recording(const fs::path& path, const AcquireConfig& config) {
  auto source = open_indexed(path, config);
  if (!source) return source.error();
  return std::unique_ptr<FrameSource>(*std::move(source));
}

Result<std::unique_ptr<IndexedSource>> open_indexed(const fs::path& path, const AcquireConfig& wanted) {
  auto good = settled(wanted);
  if (!good) return good.error();
  AcquireConfig config = *std::move(good);
  auto recording = index_recording(path, config);
  if (!recording) return recording.error();
  const std::size_t frames = recording->entries.size();
  if (frames == 0) return Error{ErrorCode::kInput, "the recording has no frame", recording->folder.string()};
  if (frames > config.limits.max_frames) {
    return Error{ErrorCode::kInput, "more frames than " + std::to_string(config.limits.max_frames),
                 recording->folder.string()};
  }
  if (config.from >= frames) {
    return Error{ErrorCode::kInput,
                 "from " + std::to_string(config.from) + " selects no frame: the recording has " +
                     std::to_string(frames) + ", counted from 0",
                 recording->folder.string()};
  }
  if (!config.sensor && !recording->sensor) {
    recording->sensor = sensor_by_name({recording->format, recording->folder, recording->device});
  }
  if (config.camera) {
    if (auto fits = check_serial(*config.camera, recording->serial); !fits) return fits.error();
  }
  if (!config.intrinsics && !recording->camera && !recording->frames_bring_camera) {
    const auto recognised = recording->sensor ? recording->sensor->model : SensorModel::kNone;
    const SensorProfile* sensor = find_sensor(config.sensor.value_or(recognised));
    if (sensor == nullptr || !sensor->camera) return missing_camera(recording->folder);
    config.intrinsics = sensor->camera;
  }
  auto empty = read_empty_picture(config);
  if (!empty) return empty.error();
  return std::make_unique<IndexedSource>(*std::move(recording), config, *std::move(empty));
}

}  // namespace scanknit
