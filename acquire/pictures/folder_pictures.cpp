// Pictures in color/, image/, images/ or rgb/, with the poses of Open3D's layout or TUM's, and a camera file.
#include <algorithm>
#include <array>
#include <string>

#include "acquire/parse/pose_list.h"
#include "acquire/parse/timed_poses.h"
#include "acquire/pictures/picture_layouts.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::array kPictureFolders = {"color", "image", "images", "rgb"};
constexpr std::array kTimedPoses = {"groundtruth.txt", "trajectory.txt"};  // TUM's format

const char* timed_poses_of(const Folder& folder) {
  const auto found =
      std::find_if(kTimedPoses.begin(), kTimedPoses.end(), [&](const char* name) { return folder.has_file(name); });
  return found == kTimedPoses.end() ? nullptr : *found;
}

const char* picture_folder(const Folder& folder) {
  const auto found = std::find_if(kPictureFolders.begin(), kPictureFolders.end(),
                                  [&](const char* name) { return folder.has_folder(name); });
  return found == kPictureFolders.end() ? nullptr : *found;
}

bool is_picture(const std::string& name) {
  const std::string ending = lower_case(fs::path(name).extension().string());
  return ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

/// The pictures, in natural order of their names.
Result<std::vector<fs::path>> list_files(const Folder& folder, const Limits& limits) {
  const auto listing = list_folder(folder.path / picture_folder(folder), limits);
  if (!listing) return listing.error();
  std::vector<fs::path> files;
  for (const std::string& name : listing->files) {
    if (is_picture(name)) files.push_back(listing->path / name);
  }
  return files;
}

Result<CameraModel> camera_of_folder(const Folder& folder, const AcquireConfig& config) {
  if (config.intrinsics) return *config.intrinsics;
  const auto found = find_camera(folder.path, config.limits);
  if (!found) return found.error();
  if (!*found) return missing_camera(folder.path);
  return CameraModel{**found, {}};
}

/// A picture's name is its time in seconds, or its number, as the trajectory has it.
Result<PictureSet> list_timed_pictures(const Folder& folder, const std::vector<fs::path>& files,
                                       const CameraModel& camera, const Limits& limits) {
  const fs::path path = folder.path / timed_poses_of(folder);
  const auto poses = read_tum_poses(path, limits);
  if (!poses) return poses.error();
  PictureSet set{.layout = "tum", .folder = folder.path};
  for (const fs::path& file : files) {
    const auto time_ns = parse_seconds_ns(file.stem().string());
    const auto pose = time_ns ? pose_at(*poses, *time_ns) : std::nullopt;
    if (pose && *pose) set.pictures.push_back({file, {}, camera, **pose});
  }
  if (set.pictures.empty()) {
    return Error{ErrorCode::kInput,
                 "no picture has a pose: expected a line 'seconds tx ty tz qx qy qz qw' for each, whose seconds, or "
                 "number, is the picture's name",
                 path.string()};
  }
  if (const std::size_t left_out = files.size() - set.pictures.size(); left_out > 0) {
    set.warnings.push_back(std::to_string(left_out) + " of " + std::to_string(files.size()) +
                           " pictures have no valid pose in " + path.filename().string() + ", and are left out");
  }
  return set;
}

}  // namespace

bool fits_folder_pictures(const Folder& folder) {
  return picture_folder(folder) != nullptr && (has_pose_list(folder) || timed_poses_of(folder) != nullptr);
}

Result<PictureSet> list_folder_pictures(const Folder& folder, const AcquireConfig& config) {
  const auto files = list_files(folder, config.limits);
  if (!files) return files.error();
  const auto camera = camera_of_folder(folder, config);
  if (!camera) return camera.error();
  if (!has_pose_list(folder)) return list_timed_pictures(folder, *files, *camera, config.limits);
  const auto poses = read_pose_list(folder, config.limits);
  if (!poses) return poses.error();
  if (poses->size() != files->size()) {
    return Error{ErrorCode::kInput,
                 std::to_string(files->size()) + " pictures, but " + std::to_string(poses->size()) +
                     " poses: one for each picture is expected, in the order of their names",
                 folder.path.string()};
  }
  PictureSet set{.layout = "folder", .folder = folder.path};
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (!(*poses)[i]) {
      set.warnings.push_back("a picture without a valid pose is left out: " + (*files)[i].string());
      continue;
    }
    set.pictures.push_back({(*files)[i], {}, *camera, *(*poses)[i]});
  }
  return set;
}

bool fits_still_camera_pictures(const Folder& folder) {
  return picture_folder(folder) != nullptr;
}

Result<PictureSet> list_still_camera_pictures(const Folder& folder, const AcquireConfig& config) {
  const auto files = list_files(folder, config.limits);
  if (!files) return files.error();
  const auto camera = camera_of_folder(folder, config);
  if (!camera) return camera.error();
  PictureSet set{.layout = "still camera", .folder = folder.path, .has_poses = false};
  for (const fs::path& file : *files) set.pictures.push_back({file, {}, *camera, Pose::Identity()});
  return set;
}

}  // namespace scanknit
