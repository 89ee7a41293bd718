#include "acquire/stereo/stereo_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "acquire/replay/text_numbers.h"
#include "acquire/stereo/keyed_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

struct FolderNames {
  const char* left;
  const char* right;
  int kitti_left;
};
constexpr std::array kFolderNames = {FolderNames{"left", "right", 0}, FolderNames{"image_0", "image_1", 0},
                                     FolderNames{"image_2", "image_3", 2}, FolderNames{"infra1", "infra2", 0}};

constexpr std::array kRigFiles = {"stereo.yaml", "stereo.yml", "stereo.xml", "camchain.yaml"};
constexpr std::array kOpenCvEnds = {".yml", ".yaml", ".xml"};  // of OpenCV's intrinsics and extrinsics
constexpr double kMostBaseline_m = 10;                         // more: another unit than metres

Error rig_error(std::string message) {
  return {ErrorCode::kInput, std::move(message)};
}

Error rig_missing(const fs::path& folder) {
  return {
      ErrorCode::kInput,
      "no file says how the two cameras are; expected stereo.yaml with left: {fx, fy, cx, cy}, right: likewise, and "
      "baseline (pictures are rectified) or T_right_left, in metres; or OpenCV's M1 D1 M2 D2 R T in stereo.yml, or "
      "in intrinsics.yml and extrinsics.yml; or KITTI's calib.txt; or Kalibr's camchain.yaml",
      folder.string()};
}

/// k1 k2 p1 p2 k3 k4 k5 k6; the rest, a thin prism's, must be 0.
Result<RationalDistortion> distortion_of(const std::vector<double>* list) {
  RationalDistortion distortion{};
  if (list == nullptr) return distortion;
  for (std::size_t i = 0; i < list->size(); ++i) {
    if (!std::isfinite((*list)[i])) return rig_error("a distortion that is no finite number");
    if (i < distortion.size()) {
      distortion[i] = (*list)[i];
    } else if ((*list)[i] != 0) {
      return rig_error("a lens with more than eight numbers of distortion is not known");
    }
  }
  return distortion;
}

int side_of(double pixels) {
  constexpr double kMostSide = 1 << 20;
  return pixels >= 1 && pixels <= kMostSide ? static_cast<int>(pixels) : 0;
}

Result<StereoCamera> checked(const CameraIntrinsics& camera, const std::vector<double>* distortion,
                             const std::string& name) {
  if ((camera.width == 0) != (camera.height == 0)) {
    return rig_error(name + ": expected width and height in pixels, or neither");
  }
  CameraIntrinsics sized = camera;
  if (sized.width == 0) sized.width = sized.height = 1;
  constexpr double kMost_px = 1e6;
  const bool is_sound = sized.is_valid() && camera.fx > 0 && camera.fy > 0 && camera.fx <= kMost_px &&
                        camera.fy <= kMost_px && std::abs(camera.cx) <= kMost_px && std::abs(camera.cy) <= kMost_px;
  if (!is_sound) return rig_error(name + ": expected fx, fy, cx, cy in pixels, with fx and fy above 0");
  const auto lens = distortion_of(distortion);
  if (!lens) return rig_error(name + ": " + lens.error().message);
  return StereoCamera{camera, *lens};
}

Result<Pose> pose_of_list(const std::vector<double>& row_major, const std::string& key) {
  auto pose = row_major.size() == 16 ? pose_from_numbers(row_major)
                                     : Result<Pose>(rig_error("expected a matrix of 4 x 4 numbers"));
  return pose ? pose : Result<Pose>(rig_error(key + ": " + pose.error().message));
}

/// Ours: left, right, and baseline or T_right_left.
Result<StereoCamera> own_camera(const KeyedNumbers& keyed, const std::string& name) {
  CameraIntrinsics camera;
  camera.width = side_of(keyed.number(name + ".width").value_or(0));
  camera.height = side_of(keyed.number(name + ".height").value_or(0));
  const std::pair<const char*, double CameraIntrinsics::*> kKeys[] = {{".fx", &CameraIntrinsics::fx},
                                                                      {".fy", &CameraIntrinsics::fy},
                                                                      {".cx", &CameraIntrinsics::cx},
                                                                      {".cy", &CameraIntrinsics::cy}};
  for (const auto& key : kKeys) {
    const auto value = keyed.number(name + key.first);
    if (!value) return rig_error(name + key.first + " is missing");
    camera.*key.second = *value;
  }
  return checked(camera, keyed.find(name + ".distortion"), name);
}

Result<StereoRig> own_rig(const KeyedNumbers& keyed) {
  StereoRig rig;
  auto left = own_camera(keyed, "left");
  if (!left) return left.error();
  rig.left = *left;
  auto right = keyed.number("right.fx") ? own_camera(keyed, "right") : std::move(left);
  if (!right) return right.error();
  rig.right = *right;
  if (const auto* matrix = keyed.find("T_right_left")) {
    const auto pose = pose_of_list(*matrix, "T_right_left");
    if (!pose) return pose.error();
    rig.T_right_left = *pose;
  } else if (const auto baseline = keyed.number("baseline")) {
    rig.T_right_left.translation().x() = -*baseline;
  } else {
    return rig_error("expected baseline, or T_right_left as 16 numbers, in metres");
  }
  return rig;
}

/// OpenCV's: K of 3 x 3 numbers.
Result<StereoCamera> opencv_camera(const KeyedNumbers& keyed, const std::string& number) {
  const auto first = [&](std::initializer_list<const char*> names, std::size_t count) {
    const std::vector<double>* found = nullptr;
    for (const char* name : names) {
      if (found == nullptr) found = keyed.find(name + number + ".data", count);
    }
    return found;
  };
  const auto* k = first({"M", "K", "cameraMatrix", "camera_matrix_"}, 9);
  if (k == nullptr) return rig_error("M" + number + " is missing, or is no matrix of 3 x 3 numbers");
  const CameraIntrinsics camera{0, 0, (*k)[0], (*k)[4], (*k)[2], (*k)[5]};
  return checked(camera, first({"D", "distCoeffs", "dist_coeffs_"}, 0), "M" + number);
}

Result<StereoRig> opencv_rig(const KeyedNumbers& keyed) {
  StereoRig rig;
  const auto left = opencv_camera(keyed, "1");
  if (!left) return left.error();
  const auto right = opencv_camera(keyed, "2");
  if (!right) return right.error();
  rig.left = *left;
  rig.right = *right;
  const auto* r = keyed.find("R.data", 9);
  const auto* t = keyed.find("T.data", 3);
  if (r == nullptr || t == nullptr) return rig_error("R (3 x 3) and T (3 numbers) are missing");
  const std::vector<double> matrix = {(*r)[0], (*r)[1], (*r)[2], (*t)[0], (*r)[3], (*r)[4], (*r)[5], (*t)[1],
                                      (*r)[6], (*r)[7], (*r)[8], (*t)[2], 0,       0,       0,       1};
  const auto pose = pose_of_list(matrix, "R, T");
  if (!pose) return pose.error();
  rig.T_right_left = *pose;
  return rig;
}

/// Kalibr's and EuRoC's: intrinsics [fx, fy, cx, cy], resolution [width, height]. `name` is "", or ends in a dot.
Result<StereoCamera> robot_camera(const KeyedNumbers& keyed, const std::string& name, const char* distortion) {
  const auto* k = keyed.find(name + "intrinsics", 4);
  if (k == nullptr) return rig_error(name + "intrinsics: expected [fx, fy, cx, cy]");
  CameraIntrinsics camera{0, 0, (*k)[0], (*k)[1], (*k)[2], (*k)[3]};
  if (const auto* size = keyed.find(name + "resolution", 2)) {
    camera.width = side_of((*size)[0]);
    camera.height = side_of((*size)[1]);
  }
  const auto model = keyed.texts.find(name + "distortion_model");
  if (model != keyed.texts.end() && model->second != "radtan" && model->second != "radial-tangential" &&
      model->second != "none") {
    return rig_error(name + "distortion_model: '" + model->second + "' is not known; expected radial-tangential");
  }
  return checked(camera, keyed.find(name + distortion), name.empty() ? "camera" : name);
}

Result<StereoRig> kalibr_rig(const KeyedNumbers& keyed) {
  StereoRig rig;
  const auto left = robot_camera(keyed, "cam0.", "distortion_coeffs");
  if (!left) return left.error();
  const auto right = robot_camera(keyed, "cam1.", "distortion_coeffs");
  if (!right) return right.error();
  const auto* matrix = keyed.find("cam1.T_cn_cnm1", 16);
  if (matrix == nullptr) return rig_error("cam1.T_cn_cnm1: expected a matrix of 4 x 4 numbers");
  const auto pose = pose_of_list(*matrix, "cam1.T_cn_cnm1");
  if (!pose) return pose.error();
  rig.left = *left;
  rig.right = *right;
  rig.T_right_left = *pose;
  return rig;
}

Result<KeyedNumbers> read_keyed(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  auto keyed = parse_keyed_numbers(*text);
  return keyed ? std::move(keyed) : Result<KeyedNumbers>(located(keyed.error(), path));
}

Result<StereoRig> rig_of_keys(const KeyedNumbers& keyed, const fs::path& path) {
  const bool is_own = keyed.numbers.contains("left.fx");
  const bool is_kalibr = keyed.numbers.contains("cam0.intrinsics");
  auto rig = is_own ? own_rig(keyed) : is_kalibr ? kalibr_rig(keyed) : opencv_rig(keyed);
  if (!rig) return located(rig.error(), path);
  rig->file = path;
  return rig;
}

/// "P0: " and twelve numbers, row by row: a camera, and where it stands on the x axis of all.
Result<StereoRig> kitti_rig(const fs::path& path, int left_number, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::array<std::optional<std::vector<double>>, 2> matrices;
  for (const TextLine& line : text_lines(*text)) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (line.words[0] != fmt::format("P{}:", left_number + static_cast<int>(side))) continue;
      const std::string_view first = line.words[0];
      const std::string_view last = line.words.back();
      const auto length = static_cast<std::size_t>(last.data() + last.size() - first.data());
      matrices[side] = parse_numbers(std::string_view(first.data(), length).substr(first.size()));
    }
  }
  StereoRig rig{.file = path};
  std::array<double, 2> place{};
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string name = fmt::format("P{}", left_number + static_cast<int>(side));
    if (!matrices[side] || matrices[side]->size() != 12) {
      return Error{ErrorCode::kInput, name + ": expected twelve numbers", path.string()};
    }
    const std::vector<double>& p = *matrices[side];
    const auto camera = checked({0, 0, p[0], p[5], p[2], p[6]}, nullptr, name);
    if (!camera) return located(camera.error(), path);
    (side == 0 ? rig.left : rig.right) = *camera;
    place[side] = p[3] / p[0];
  }
  rig.T_right_left.translation().x() = place[1] - place[0];
  return rig;
}

/// Each camera's sensor.yaml has T_BS, where it stands in the body's frame.
Result<StereoRig> euroc_rig(const StereoFolders& folders, const Limits& limits) {
  StereoRig rig{.file = folders.left.parent_path() / "sensor.yaml"};
  std::array<Pose, 2> T_body_camera;
  for (std::size_t side = 0; side < 2; ++side) {
    const fs::path path = (side == 0 ? folders.left : folders.right).parent_path() / "sensor.yaml";
    const auto keyed = read_keyed(path, limits);
    if (!keyed) return keyed.error();
    const auto camera = robot_camera(*keyed, "", "distortion_coefficients");
    if (!camera) return located(camera.error(), path);
    (side == 0 ? rig.left : rig.right) = *camera;
    const auto* matrix = keyed->find("T_BS.data", 16);
    if (matrix == nullptr) return Error{ErrorCode::kInput, "T_BS: expected data of 16 numbers", path.string()};
    const auto pose = pose_of_list(*matrix, "T_BS");
    if (!pose) return located(pose.error(), path);
    T_body_camera[side] = *pose;
  }
  rig.T_right_left = T_body_camera[1].inverse() * T_body_camera[0];
  return rig;
}

/// OpenCV's sample program writes the cameras and their places into two files.
std::optional<Result<StereoRig>> rig_of_two_files(const Folder& folder, const Limits& limits) {
  for (const char* end : kOpenCvEnds) {
    const std::string names[] = {std::string("intrinsics") + end, std::string("extrinsics") + end};
    if (!folder.has_file(names[0]) || !folder.has_file(names[1])) continue;
    auto cameras = read_keyed(folder.path / names[0], limits);
    if (!cameras) return cameras.error();
    auto places = read_keyed(folder.path / names[1], limits);
    if (!places) return places.error();
    cameras->numbers.merge(places->numbers);
    return rig_of_keys(*cameras, folder.path / names[1]);
  }
  return std::nullopt;
}

Result<StereoRig> find_rig(const StereoFolders& folders, const Limits& limits) {
  const Folder& folder = folders.recording;
  for (const char* name : kRigFiles) {
    if (!folder.has_file(name)) continue;
    const auto keyed = read_keyed(folder.path / name, limits);
    return keyed ? rig_of_keys(*keyed, folder.path / name) : keyed.error();
  }
  if (auto rig = rig_of_two_files(folder, limits)) return *std::move(rig);
  if (folder.has_file("calib.txt")) return kitti_rig(folder.path / "calib.txt", folders.kitti_left, limits);
  if (folders.is_euroc) return euroc_rig(folders, limits);
  return rig_missing(folder.path);
}

/// The way from the left camera to the right one, in metres, mostly to the right.
Result<void> check_baseline(const StereoRig& rig) {
  const auto refuse = [&](std::string message) {
    return Error{ErrorCode::kInput, std::move(message), rig.file.string()};
  };
  const Eigen::Vector3d t = rig.T_right_left.translation();
  if (!(rig.baseline_m() > 0)) return refuse("the baseline is 0: two cameras at one place see no depth");
  if (rig.baseline_m() > kMostBaseline_m) {
    return refuse(
        fmt::format("the baseline is {:.4g} m; expected at most {} m. Is the file's unit millimetres? State "
                    "metres",
                    rig.baseline_m(), kMostBaseline_m));
  }
  if (std::abs(t.x()) < std::max(std::abs(t.y()), std::abs(t.z()))) {
    return refuse("the cameras are not side by side: turn the pictures, so that the baseline is along their rows");
  }
  if (t.x() > 0) {
    return refuse(
        "the right camera is on the left: expected x of T_right_left (OpenCV's T) below 0, or a baseline "
        "above 0. Exchange the two folders of pictures together with their cameras, or the sign");
  }
  return {};
}

}  // namespace

std::optional<StereoFolders> find_stereo_folders(const fs::path& path, const Limits& limits) {
  for (const fs::path& place : {path, path / "mav0"}) {
    const auto folder = list_folder(place, limits);
    if (!folder) continue;
    for (const FolderNames& names : kFolderNames) {
      if (!folder->has_folder(names.left) || !folder->has_folder(names.right)) continue;
      return StereoFolders{*folder, place / names.left, place / names.right, names.kitti_left, false};
    }
    std::error_code code;
    const fs::path left = place / "cam0" / "data";
    const fs::path right = place / "cam1" / "data";
    if (fs::is_directory(left, code) && fs::is_directory(right, code)) {
      return StereoFolders{*folder, left, right, 0, true};
    }
  }
  return std::nullopt;
}

Result<StereoRig> read_stereo_rig(const StereoFolders& folders, const Limits& limits) {
  auto rig = find_rig(folders, limits);
  if (!rig) return rig;
  if (const auto sound = check_baseline(*rig); !sound) return sound.error();
  return rig;
}

}  // namespace scanknit
