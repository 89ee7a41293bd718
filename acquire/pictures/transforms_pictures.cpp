// Pictures of transforms.json (nerfstudio, instant-ngp, NeRF), with `mask_path` where the file names masks.
#include <string>

#include "acquire/parse/transforms_json.h"
#include "acquire/pictures/picture_layouts.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"

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

/// The published synthetic sets of NeRF have the views in files of this name.
constexpr const char* kNerfFile = "transforms_train.json";

/// NeRF's files leave out the pictures' size, which is that of the first one.
Result<void> add_size(const Folder& folder, const Limits& limits, nlohmann::json& json) {
  const auto& frames = json["frames"];
  if (frames.empty() || find_number(frames[0], json, "w") || find_number(frames[0], json, "h")) return {};
  const std::string name = text_at(frames[0], "file_path");
  if (name.empty()) return {};
  const auto path = path_inside(folder, name);
  if (!path) return path.error();
  const auto bytes = read_file(*path, limits.max_image_bytes);
  if (!bytes) return bytes.error();
  const auto picture = decode_picture(*bytes, limits);
  if (!picture) return located(picture.error(), *path);
  json["w"] = picture->width();
  json["h"] = picture->height();
  return {};
}

}  // namespace

bool fits_transforms_pictures(const Folder& folder) {
  return folder.has_file(kTransformsFile) || folder.has_file(kNerfFile);
}

Result<PictureSet> list_transforms_pictures(const Folder& folder, const AcquireConfig& config) {
  const fs::path path = folder.path / (folder.has_file(kTransformsFile) ? kTransformsFile : kNerfFile);
  auto json = read_transforms(path, config.limits);
  if (!json) return json.error();
  if (!config.intrinsics) {
    if (const auto sized = add_size(folder, config.limits, *json); !sized) return sized.error();
  }
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
