#include "acquire/replay/camera_files.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquire/replay/text_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::array kTextNames = {"intrinsics.K.txt", "camera-intrinsics.txt", "camera_intrinsics.txt",
                                   "intrinsics.txt"};
constexpr const char* kJsonName = "camera_intrinsic.json";

// Entries of the matrix by row and column; `width` and `height` may be 0.
template <typename Entry>
Result<CameraIntrinsics> camera_from_matrix(int width, int height, Entry k) {
  const CameraIntrinsics camera{width, height, k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
  // Size is not a matter of the matrix: 1 stands in for an unknown one.
  const CameraIntrinsics sized{1, 1, camera.fx, camera.fy, camera.cx, camera.cy};
  if (!sized.is_valid() || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1) {
    return Error{ErrorCode::kInput, "not a camera matrix; expected fx 0 cx / 0 fy cy / 0 0 1 with fx and fy not 0"};
  }
  return camera;
}

}  // namespace

Result<CameraIntrinsics> parse_camera_matrix(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != 9) {
    return Error{ErrorCode::kInput, "not a camera matrix; expected nine numbers, fx 0 cx / 0 fy cy / 0 0 1"};
  }
  return camera_from_matrix(0, 0, [&](std::size_t row, std::size_t column) { return (*numbers)[3 * row + column]; });
}

Result<CameraIntrinsics> parse_camera_json(std::string_view text) {
  const Error malformed{ErrorCode::kInput,
                        "not a camera; expected {\"width\", \"height\", \"intrinsic_matrix\": nine numbers, column by "
                        "column}"};
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("intrinsic_matrix")) return malformed;
  const auto& matrix = json["intrinsic_matrix"];
  if (!matrix.is_array() || matrix.size() != 9) return malformed;
  std::array<double, 9> k{};
  for (std::size_t i = 0; i < k.size(); ++i) {
    if (!matrix[i].is_number()) return malformed;
    k[i] = matrix[i].get<double>();
  }
  const auto side = [&](const char* name) {
    constexpr double kMaxSide = 1 << 30;
    if (!json.contains(name) || !json[name].is_number()) return 0;
    const double value = json[name].get<double>();
    return value >= 1 && value <= kMaxSide ? static_cast<int>(value) : 0;
  };
  const int width = side("width"), height = side("height");
  if ((width == 0) != (height == 0)) {
    return Error{ErrorCode::kInput, "states only one of \"width\" and \"height\"; expected both, in pixels, or none"};
  }
  return camera_from_matrix(width, height, [&](std::size_t row, std::size_t column) { return k[3 * column + row]; });
}

Result<std::optional<double>> find_depth_scale(const fs::path& folder, const Limits& limits) {
  const std::optional<double> none;
  std::error_code ignored;
  if (!fs::exists(folder / kJsonName, ignored)) return none;
  const auto text = read_text_file(folder / kJsonName, limits.max_text_bytes);
  if (!text) return text.error();  // the usual scale would be another world
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("depth_scale") || !json["depth_scale"].is_number()) return none;
  const double scale = json["depth_scale"].get<double>();
  return scale >= 1 && scale <= 1e7 ? std::optional(scale) : none;
}

Result<std::optional<CameraIntrinsics>> find_camera(const fs::path& folder, const Limits& limits) {
  std::error_code code;
  for (const fs::path& place : {folder, fs::absolute(folder, code).lexically_normal().parent_path()}) {
    for (const char* name : kTextNames) {
      if (!fs::exists(place / name, code)) continue;
      const auto text = read_text_file(place / name, limits.max_text_bytes);
      if (!text) return text.error();
      const auto camera = parse_camera_matrix(*text);
      if (!camera) return located(camera.error(), place / name);
      return std::optional(*camera);
    }
    if (!fs::exists(place / kJsonName, code)) continue;
    const auto text = read_text_file(place / kJsonName, limits.max_text_bytes);
    if (!text) return text.error();
    const auto camera = parse_camera_json(*text);
    if (!camera) return located(camera.error(), place / kJsonName);
    return std::optional(*camera);
  }
  return std::optional<CameraIntrinsics>();
}

Error missing_camera(const fs::path& folder) {
  return Error{ErrorCode::kInput,
               "the recording does not say its camera's intrinsics; give them as "
               "acquire.intrinsics=[525,525,319.5,239.5] (fx, fy, cx, cy in pixels of the depth picture), or put "
               "a 3x3 matrix beside the frames as camera-intrinsics.txt",
               folder.string()};
}

}  // namespace scanknit
