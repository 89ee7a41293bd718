// Pictures of the Middlebury multi-view sets (vision.middlebury.edu/mview/data): NAME_par.txt, a count and lines of
// "NAME.png k11 .. k33 r11 .. r33 t1 t2 t3", world-to-camera.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "acquire/pictures/picture_layouts.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNumbers = 21;

const std::string* par_file(const Folder& folder) {
  const auto found = std::find_if(folder.files.begin(), folder.files.end(),
                                  [](const std::string& name) { return name.ends_with("_par.txt"); });
  return found == folder.files.end() ? nullptr : &*found;
}

/// The camera and its pose of 21 numbers; nothing if they are none.
bool take_numbers(const std::array<double, kNumbers>& n, PlacedPicture& picture) {
  if (std::any_of(n.begin(), n.end(), [](double value) { return !std::isfinite(value); })) return false;
  CameraIntrinsics& k = picture.camera.intrinsics;
  const double scale = n[8];
  if (scale == 0) return false;
  k.fx = n[0] / scale;
  k.cx = n[2] / scale;
  k.fy = n[4] / scale;
  k.cy = n[5] / scale;
  Eigen::Matrix4d T_camera_world = Eigen::Matrix4d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      T_camera_world(row, column) = n[static_cast<std::size_t>(9 + 3 * row + column)];
    }
    T_camera_world(row, 3) = n[static_cast<std::size_t>(18 + row)];
  }
  const auto pose = pose_from_matrix(T_camera_world);
  const CameraIntrinsics sized{1, 1, k.fx, k.fy, k.cx, k.cy};  // the file does not tell the size
  if (!pose || !sized.is_valid()) return false;
  picture.T_world_camera = pose->inverse();
  return true;
}

}  // namespace

bool fits_par_pictures(const Folder& folder) {
  return par_file(folder) != nullptr;
}

Result<PictureSet> list_par_pictures(const Folder& folder, const AcquireConfig& config) {
  const fs::path path = folder.path / *par_file(folder);
  const auto text = read_text_file(path, config.limits.max_text_bytes);
  if (!text) return text.error();
  PictureSet set{.layout = "par", .folder = folder.path};
  const auto lines = text_lines(*text);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const auto& words = lines[i].words;
    const std::string where = path.string() + ":" + std::to_string(lines[i].number);
    std::array<double, kNumbers> numbers{};
    bool is_numeric = words.size() == kNumbers + 1;
    for (std::size_t k = 0; is_numeric && k < kNumbers; ++k) {
      const auto value = parse_double(words[k + 1]);
      is_numeric = value.has_value();
      numbers[k] = value.value_or(0);
    }
    PlacedPicture picture;
    if (!is_numeric || !take_numbers(numbers, picture)) {
      return Error{ErrorCode::kInput, "expected a picture's name and 21 numbers: K, R and t, row by row", where};
    }
    auto file = resolve_inside(folder.path, words[0]);
    if (auto* drop = std::get_if<Drop>(&file)) return Error{ErrorCode::kInput, drop->error.message, where};
    picture.picture = std::get<fs::path>(std::move(file));
    if (config.intrinsics) picture.camera = *config.intrinsics;
    set.pictures.push_back(std::move(picture));
  }
  return set;
}

}  // namespace scanknit
