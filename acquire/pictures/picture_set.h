// PictureSet: pictures of a thing from known places, without depth, and masks that say what of them is the thing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/masks/found_masks.h"
#include "core/axes.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// A picture as the files name it, before it is opened.
struct PlacedPicture {
  std::filesystem::path picture;
  std::filesystem::path mask;  ///< empty: the picture's own alpha, or the difference from the empty picture
  CameraModel camera;          ///< of `picture`; width and height 0: the picture's
  Pose T_world_camera = Pose::Identity();
};

struct PictureSet {
  std::string layout;  ///< "transforms.json", "colmap", "par", "folder", "tum", "still camera"
  std::filesystem::path folder = {};
  UpAxis world_up = UpAxis::kMinusY;
  std::vector<PlacedPicture> pictures = {};
  bool has_poses = true;  ///< false: pictures of one camera that stood still; their poses are identities
  std::vector<std::string> warnings = {};
};

/// Lists the pictures of a folder. Layouts, asked in this order: transforms.json of nerfstudio and instant-ngp;
/// COLMAP's text model (cameras.txt, images.txt; also in sparse/0 or sparse); Middlebury's NAME_par.txt; pictures in
/// color/, image/, images/ or rgb/ with a camera and trajectory.log, trajectory.json or, in TUM's format,
/// groundtruth.txt or trajectory.txt; the same without poses. A mask is what the file names, else STEM.png or NAME.png
/// in masks/, mask/ or silhouettes/ (or in `config.masks`, which may also be kAlphaMasks: the pictures' own alpha, or
/// kChromaMasks, kGrabCutMasks). config.from, to and every choose some. The camera is config.intrinsics, or the colour
/// camera of config.camera, if one of them is given. Errors (kInput): none of these; a file that cannot be read; no
/// picture with a pose. Errors (kConfig): both cameras are given; check_cameras()'s; config.camera without colour.
[[nodiscard]] Result<PictureSet> open_pictures(const std::filesystem::path& path, const AcquireConfig& config);

/// A picture without lens distortion, and how much of each pixel is the thing: 0 to 255.
struct MaskedPicture {
  ColourImage colour;
  Image<std::uint8_t> mask;
  CameraIntrinsics camera;
};

/// `most_pixels`: a larger picture is made smaller, by the mean of squares of whole pixels. Errors (kInput): a file is
/// missing or cannot be read; sizes that differ from the camera's or among the files; no mask at all; a mask that is
/// empty, full, or most likely inverted.
[[nodiscard]] Result<MaskedPicture> read_masked_picture(const PlacedPicture& picture, const EmptyPicture& empty,
                                                        const AcquireConfig& config, std::size_t most_pixels);

}  // namespace scanknit
