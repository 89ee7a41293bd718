#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "acquire/masks/mask_files.h"
#include "acquire/pictures/picture_layouts.h"
#include "acquire/pictures/picture_set.h"
#include "acquire/sensor/scanner_camera.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

struct PictureLayout {
  bool (*fits)(const Folder&);
  Result<PictureSet> (*list)(const Folder&, const AcquireConfig&);
};

// Asked in this order; the first that fits is taken.
constexpr std::array kPictureLayouts = {PictureLayout{fits_transforms_pictures, list_transforms_pictures},
                                        PictureLayout{fits_colmap_pictures, list_colmap_pictures},
                                        PictureLayout{fits_par_pictures, list_par_pictures},
                                        PictureLayout{fits_folder_pictures, list_folder_pictures},
                                        PictureLayout{fits_still_camera_pictures, list_still_camera_pictures}};

/// With the colour camera of acquire.camera as its intrinsics, which are those of the pictures here.
Result<AcquireConfig> with_colour_camera(const AcquireConfig& config) {
  if (!config.camera) return config;
  if (auto good = check_cameras(config); !good) return good.error();
  const auto refuse = [&](const char* what) { return Error{ErrorCode::kConfig, what, config.camera->file}; };
  if (!config.camera->colour) {
    return refuse("acquire.camera: silhouettes are seen in colour pictures, expected colour: in this file");
  }
  if (config.intrinsics) {
    return refuse("acquire.camera and acquire.intrinsics both state the pictures' camera; give one of them");
  }
  AcquireConfig result = config;
  result.intrinsics = config.camera->colour;
  return result;
}

void find_masks(const AcquireConfig& config, PictureSet& set) {
  const MaskOrigin origin = mask_origin(config);
  for (PlacedPicture& picture : set.pictures) {
    if (origin == MaskOrigin::kAlpha || origin == MaskOrigin::kChroma || origin == MaskOrigin::kGrabCut) {
      picture.mask.clear();
      continue;
    }
    if (origin == MaskOrigin::kFiles) {
      picture.mask = find_mask(set.folder / *config.masks, picture.picture);
      continue;
    }
    for (const char* name : kMaskFolders) {
      if (!picture.mask.empty()) break;
      picture.mask = find_mask(set.folder / name, picture.picture);
    }
  }
}

void choose(const AcquireConfig& config, std::vector<PlacedPicture>& pictures) {
  std::vector<PlacedPicture> chosen;
  for (std::size_t i = config.from; i < pictures.size() && i <= config.to; ++i) {
    if ((i - config.from) % config.every == 0) chosen.push_back(std::move(pictures[i]));
  }
  pictures = std::move(chosen);
}

}  // namespace

Result<PictureSet> open_pictures(const fs::path& path, const AcquireConfig& wanted) {
  if (wanted.every == 0) return Error{ErrorCode::kConfig, "every: expected 1 or more"};
  const auto good = with_colour_camera(wanted);
  if (!good) return good.error();
  const AcquireConfig& config = *good;
  const auto folder = list_folder(path, config.limits);
  if (!folder) return folder.error();
  const auto layout = std::find_if(kPictureLayouts.begin(), kPictureLayouts.end(),
                                   [&](const PictureLayout& known) { return known.fits(*folder); });
  if (layout == kPictureLayouts.end()) {
    return Error{
        ErrorCode::kInput,
        "no pictures with known cameras: expected transforms.json; or cameras.txt and images.txt of COLMAP; or "
        "NAME_par.txt of Middlebury; or color/ or images/ with camera_intrinsic.json and trajectory.log (or, in TUM's "
        "format, trajectory.txt), of a turntable without trajectory",
        path.string()};
  }
  auto set = layout->list(*folder, config);
  if (!set) return set.error();
  if (set->pictures.size() > config.limits.max_frames) {
    return Error{ErrorCode::kInput, "more pictures than a recording may have", path.string()};
  }
  choose(config, set->pictures);
  if (set->pictures.empty()) return Error{ErrorCode::kInput, "no picture with a pose", path.string()};
  find_masks(config, *set);
  return set;
}

}  // namespace scanknit
