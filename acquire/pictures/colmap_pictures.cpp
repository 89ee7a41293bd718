// Pictures of COLMAP's text model (colmap.github.io, "Output Format"): cameras.txt, images.txt; the pictures are in
// images/ beside the model or above it.
#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>

#include "acquire/pictures/picture_layouts.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCameras = "cameras.txt";
constexpr const char* kImages = "images.txt";
constexpr std::array kModelFolders = {".", "sparse/0", "sparse"};

fs::path model_folder(const Folder& folder) {
  std::error_code code;
  for (const char* name : kModelFolders) {
    const fs::path model = (folder.path / name).lexically_normal();
    if (fs::is_regular_file(model / kCameras, code) && fs::is_regular_file(model / kImages, code)) return model;
  }
  return {};
}

/// Where each parameter of a lens model goes, in the order of the file.
struct LensModel {
  std::string_view name;
  std::string_view parameters;  ///< f: fx and fy; x, y: fx, fy; u, v: cx, cy; 0 to 4: k1 k2 p1 p2 k3
};
constexpr std::array kLenses = {LensModel{"SIMPLE_PINHOLE", "fuv"}, LensModel{"PINHOLE", "xyuv"},
                                LensModel{"SIMPLE_RADIAL", "fuv0"}, LensModel{"RADIAL", "fuv01"},
                                LensModel{"OPENCV", "xyuv0123"}};

void set_parameter(char parameter, double value, CameraModel& camera) {
  CameraIntrinsics& k = camera.intrinsics;
  if (parameter == 'f') k.fx = k.fy = value;
  if (parameter == 'x') k.fx = value;
  if (parameter == 'y') k.fy = value;
  if (parameter == 'u') k.cx = value - 0.5;  // COLMAP counts from the corner of the first pixel
  if (parameter == 'v') k.cy = value - 0.5;
  if (parameter >= '0' && parameter <= '4') camera.distortion[static_cast<std::size_t>(parameter - '0')] = value;
}

/// "ID MODEL WIDTH HEIGHT PARAMETERS".
Result<CameraModel> camera_of_line(const TextLine& line, const std::string& where) {
  const auto& words = line.words;
  const auto width = words.size() > 3 ? parse_integer(words[2]) : std::nullopt;
  const auto height = words.size() > 3 ? parse_integer(words[3]) : std::nullopt;
  constexpr std::int64_t kMostPixels = 1 << 20;
  if (!width || !height || *width < 1 || *height < 1 || *width > kMostPixels || *height > kMostPixels) {
    return Error{ErrorCode::kInput, "expected CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS", where};
  }
  const auto lens =
      std::find_if(kLenses.begin(), kLenses.end(), [&](const LensModel& model) { return model.name == words[1]; });
  if (lens == kLenses.end()) {
    return Error{ErrorCode::kInput,
                 "the lens model " + std::string(words[1]) +
                     " is not read, expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV; undistort the "
                     "pictures first (colmap image_undistorter)",
                 where};
  }
  CameraModel camera;
  camera.intrinsics.width = static_cast<int>(*width);
  camera.intrinsics.height = static_cast<int>(*height);
  constexpr std::size_t kFirst = 4;
  bool is_numeric = words.size() == kFirst + lens->parameters.size();
  for (std::size_t i = 0; is_numeric && i < lens->parameters.size(); ++i) {
    const auto value = parse_double(words[kFirst + i]);
    is_numeric = value && std::isfinite(*value);
    if (is_numeric) set_parameter(lens->parameters[i], *value, camera);
  }
  if (!is_numeric || !camera.intrinsics.is_valid()) {
    return Error{ErrorCode::kInput,
                 "expected " + std::to_string(lens->parameters.size()) + " finite parameters of " +
                     std::string(lens->name) + ", a focal length that is not 0",
                 where};
  }
  return camera;
}

Result<std::map<std::string, CameraModel, std::less<>>> read_cameras(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::map<std::string, CameraModel, std::less<>> cameras;
  for (const TextLine& line : text_lines(*text)) {
    const auto camera = camera_of_line(line, path.string() + ":" + std::to_string(line.number));
    if (!camera) return camera.error();
    cameras[std::string(line.words[0])] = *camera;
  }
  return cameras;
}

/// The folder whose images/ has the picture, else that folder's own; empty: none.
fs::path find_picture(const fs::path& model, std::string_view name) {
  std::error_code code;
  for (const char* up : {".", "..", "../.."}) {
    for (const char* in : {"images", "."}) {
      const fs::path folder = (model / up / in).lexically_normal();
      const auto path = resolve_inside(folder, name);
      if (const auto* found = std::get_if<fs::path>(&path); found != nullptr && fs::is_regular_file(*found, code)) {
        return *found;
      }
    }
  }
  return {};
}

}  // namespace

bool fits_colmap_pictures(const Folder& folder) {
  return !model_folder(folder).empty();
}

Result<PictureSet> list_colmap_pictures(const Folder& folder, const AcquireConfig& config) {
  const fs::path model = model_folder(folder);
  const auto cameras = read_cameras(model / kCameras, config.limits);
  if (!cameras) return cameras.error();
  const fs::path path = model / kImages;
  const auto text = read_text_file(path, config.limits.max_text_bytes);
  if (!text) return text.error();
  PictureSet set{.layout = "colmap", .folder = folder.path};
  // "ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", world-to-camera; the line after it, which may be blank, has its points.
  std::string_view rest = *text;
  bool has_points_next = false;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = take_line(rest);
    if (has_points_next) {
      has_points_next = false;
      continue;
    }
    const auto parsed = text_lines(line);
    if (parsed.empty()) continue;
    const auto& words = parsed.front().words;
    const std::string where = path.string() + ":" + std::to_string(number);
    has_points_next = true;
    std::array<double, 7> numbers{};
    bool is_numeric = words.size() >= 10;
    for (std::size_t i = 0; is_numeric && i < numbers.size(); ++i) {
      const auto value = parse_double(words[i + 1]);
      is_numeric = value && std::isfinite(*value);
      numbers[i] = value.value_or(0);
    }
    const Eigen::Quaterniond turn(numbers[0], numbers[1], numbers[2], numbers[3]);
    if (!is_numeric || !(std::abs(turn.norm() - 1) < 0.01)) {
      return Error{ErrorCode::kInput,
                   "expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME with a quaternion of length 1", where};
    }
    const auto camera = cameras->find(words[8]);
    if (camera == cameras->end()) {
      return Error{ErrorCode::kInput, "the camera " + std::string(words[8]) + " is not in cameras.txt", where};
    }
    Pose T_camera_world = Pose::Identity();
    T_camera_world.linear() = turn.normalized().toRotationMatrix();
    T_camera_world.translation() = Eigen::Vector3d(numbers[4], numbers[5], numbers[6]);
    if (const auto pose = pose_from_matrix(T_camera_world.matrix()); !pose) {
      return Error{ErrorCode::kInput, pose.error().message, where};
    }
    // A name may have blanks in it.
    std::string_view name(words[9].data(),
                          static_cast<std::size_t>(words.back().data() + words.back().size() - words[9].data()));
    PlacedPicture picture;
    picture.picture = find_picture(model, name);
    if (picture.picture.empty()) {
      set.warnings.push_back("a picture of images.txt is not there and is left out: " + std::string(name));
      continue;
    }
    picture.camera = config.intrinsics.value_or(camera->second);
    picture.T_world_camera = T_camera_world.inverse();
    set.pictures.push_back(std::move(picture));
  }
  return set;
}

}  // namespace scanknit
