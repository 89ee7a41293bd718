// Pictures of transforms.json (nerfstudio, instant-ngp), with `mask_path` where the file names masks.
#include <string>

#include "acquire/parse/transforms_json.h"
#include "acquire/pictures/picture_layouts.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

Result<fs::path> path_inside(const Folder& folder, const std::string& name) {
  auto path = resolve_inside(folder.path, name);
  if (auto* drop = std::get_if<Drop>(&path)) {
    return Error{ErrorCode::kInput, drop->error.message, (folder.path / kTransformsFile).string()};
  }
  fs::path found = std::get<fs::path>(std::move(path));
  if (!found.has_extension()) found += ".png";  // instant-ngp leaves it out
  return found;
}

}  // namespace

bool fits_transforms_pictures(const Folder& folder) {
  return folder.has_file(kTransformsFile);
}

Result<PictureSet> list_transforms_pictures(const Folder& folder, const AcquireConfig& config) {
  const fs::path path = folder.path / kTransformsFile;
  const auto json = read_transforms(path, config.limits);
  if (!json) return json.error();
  const auto change = applied_change(*json, path);
  if (!change) return change.error();
  PictureSet set{.layout = "transforms.json", .folder = folder.path, .world_up = change->world_up()};
  for (const auto& frame : (*json)["frames"]) {
    const std::string name = text_at(frame, "file_path");
    const auto pose = pose_of(frame, *change, path);
    if (name.empty() || !pose || !*pose) {
      set.warnings.push_back("a frame without a file_path or a valid transform_matrix is left out" +
                             (name.empty() ? std::string() : ": " + name));
      continue;
    }
    PlacedPicture picture;
    picture.T_world_camera = **pose;
    const auto file = path_inside(folder, name);
    if (!file) return file.error();
    picture.picture = *file;
    if (const std::string mask = text_at(frame, "mask_path"); !mask.empty()) {
      const auto mask_file = path_inside(folder, mask);
      if (!mask_file) return mask_file.error();
      picture.mask = *mask_file;
    }
    if (config.intrinsics) {
      picture.camera = *config.intrinsics;
    } else {
      const auto camera = camera_of(frame, *json);
      if (!camera) return located(camera.error(), path);
      picture.camera = *camera;
    }
    set.pictures.push_back(std::move(picture));
  }
  return set;
}

}  // namespace scanknit
