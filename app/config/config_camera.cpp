#include "app/config/config_camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"
#include "core/files/read_file.h"
#include "core/limits.h"

namespace scanknit {
namespace {

constexpr std::array<std::string_view, 6> kParts = {"colour",         "depth",      "T_colour_depth",
                                                    "time_offset_ms", "depth_bias", "serial"};
constexpr const char* kCameraKeys = "width, height, fx, fy, cx, cy, distortion";

std::optional<double> number_of(const YamlNode& node, const YamlComplaint& complain) {
  const auto number = node.kind == YamlNode::Kind::kScalar ? parse_finite(node.text) : std::nullopt;
  if (!number) complain(node, fmt::format("expected a number, got '{}'", node.text));
  return number;
}

/// A width or height in pixels.
std::optional<int> pixels_of(const YamlNode& node, const YamlComplaint& complain) {
  constexpr std::int64_t kLargestSide = 65'535;  // the limit of our PNG reader
  const auto pixels = parse_integer(node.text);
  if (pixels && *pixels >= 1 && *pixels <= kLargestSide) return static_cast<int>(*pixels);
  complain(node, fmt::format("expected a whole number of pixels, 1..{}, got '{}'", kLargestSide, node.text));
  return std::nullopt;
}

/// Sets one entry of a map in `model`. False when it complained.
bool set_entry(CameraModel& model, const YamlNode& key, const YamlNode& value, const YamlComplaint& complain) {
  CameraIntrinsics& camera = model.intrinsics;
  if (key.text == "width" || key.text == "height") {
    const auto pixels = pixels_of(value, complain);
    if (pixels) (key.text == "width" ? camera.width : camera.height) = *pixels;
    return pixels.has_value();
  }
  if (key.text == "distortion") {
    const auto numbers = read_numbers(value, model.distortion.size(), complain);
    if (numbers) std::copy(numbers->begin(), numbers->end(), model.distortion.begin());
    return numbers.has_value();
  }
  if (key.text == "intrinsic_matrix") {  // Open3D writes the 3x3 matrix column by column
    const auto matrix = read_numbers(value, 9, complain);
    if (!matrix) return false;
    camera.fx = (*matrix)[0], camera.fy = (*matrix)[4], camera.cx = (*matrix)[6], camera.cy = (*matrix)[7];
    return true;
  }
  double* const target = key.text == "fx"   ? &camera.fx
                         : key.text == "fy" ? &camera.fy
                         : key.text == "cx" ? &camera.cx
                         : key.text == "cy" ? &camera.cy
                                            : nullptr;
  if (target == nullptr) {
    complain(key, fmt::format("unknown key '{}'; known are {}", key.text, kCameraKeys));
    return false;
  }
  const auto number = number_of(value, complain);
  if (number) *target = *number;
  return number.has_value();
}

/// columns * rows numbers, none beyond `most`.
bool read_field(const YamlNode& node, const DepthBias& bias, double most, std::vector<double>& field,
                const YamlComplaint& complain) {
  const auto count = static_cast<std::size_t>(bias.columns) * static_cast<std::size_t>(bias.rows);
  auto numbers = read_numbers(node, count, complain);
  if (!numbers) return false;
  const auto beyond = std::find_if(numbers->begin(), numbers->end(), [most](double n) { return std::abs(n) > most; });
  if (beyond != numbers->end()) {
    complain(node, fmt::format("{}, expected {} to {}", *beyond, -most, most));
    return false;
  }
  field = *std::move(numbers);
  return true;
}

/// Calls take(key, value) for each entry of a map. False if it is none, an entry is there twice, or take() gave false.
template <typename Take>
bool read_entries(const YamlNode& node, std::string_view expected, const YamlComplaint& complain, const Take& take) {
  if (node.kind != YamlNode::Kind::kMap) {
    complain(node, fmt::format("expected a map of {}", expected));
    return false;
  }
  std::set<std::string> seen;
  bool is_good = true;
  for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
    const YamlNode& key = node.children[i];
    if (!seen.insert(key.text).second) {
      complain(key, fmt::format("duplicate key '{}'", key.text));
      is_good = false;
    } else {
      is_good = take(key, node.children[i + 1]) && is_good;
    }
  }
  return is_good;
}

std::optional<DepthBias> bias_of(const YamlNode& node, const YamlComplaint& complain) {
  constexpr const char* kKnown = "columns, rows, scale, shift_per_m";
  DepthBias bias;
  const YamlNode *scale = nullptr, *shift = nullptr;
  const bool is_good = read_entries(node, kKnown, complain, [&](const YamlNode& key, const YamlNode& value) {
    if (key.text == "scale" || key.text == "shift_per_m") {
      (key.text == "scale" ? scale : shift) = &value;
      return true;
    }
    if (key.text != "columns" && key.text != "rows") {
      complain(key, fmt::format("unknown key '{}'; known are {}", key.text, kKnown));
      return false;
    }
    const auto count = value.kind == YamlNode::Kind::kScalar ? parse_integer(value.text) : std::nullopt;
    if (!count || *count < DepthBias::kFewest || *count > DepthBias::kMost) {
      complain(value, fmt::format("{}: expected a whole number, {}..{}, got '{}'", key.text, DepthBias::kFewest,
                                  DepthBias::kMost, value.text));
      return false;
    }
    (key.text == "columns" ? bias.columns : bias.rows) = static_cast<int>(*count);
    return true;
  });
  if (!is_good) return std::nullopt;
  if (bias.columns == 0 || bias.rows == 0 || scale == nullptr || shift == nullptr) {
    complain(node, fmt::format("expected all of {}", kKnown));
    return std::nullopt;
  }
  const bool is_whole = read_field(*scale, bias, DepthBias::kMostScale, bias.scale, complain) &&
                        read_field(*shift, bias, DepthBias::kMostShift_per_m, bias.shift_per_m, complain);
  return is_whole ? std::optional(bias) : std::nullopt;
}

/// A camera whose size is given.
std::optional<CameraModel> sized_camera_of(const YamlNode& node, const YamlComplaint& complain) {
  auto camera = read_camera_map(node, complain);
  if (camera && camera->intrinsics.width == 0) {
    complain(node, "width and height are missing");
    return std::nullopt;
  }
  return camera;
}

/// Seconds.
std::optional<double> offset_of(const YamlNode& node, const YamlComplaint& complain) {
  constexpr double kMost_ms = 1000;
  const auto offset_ms = number_of(node, complain);
  if (!offset_ms) return std::nullopt;
  if (std::abs(*offset_ms) > kMost_ms) {
    complain(node, fmt::format("{}, expected {} to {}", *offset_ms, -kMost_ms, kMost_ms));
    return std::nullopt;
  }
  return *offset_ms / 1000;
}

bool set_part(ScannerCamera& camera, const YamlNode& key, const YamlNode& value, const YamlComplaint& complain) {
  const auto named = [&](const YamlNode& where, const std::string& what) { complain(where, key.text + ": " + what); };
  if (key.text == "colour") return (camera.colour = sized_camera_of(value, named)).has_value();
  if (key.text == "depth") return (camera.depth = sized_camera_of(value, named)).has_value();
  if (key.text == "T_colour_depth") return (camera.T_colour_depth = read_pose(value, named)).has_value();
  if (key.text == "time_offset_ms") return (camera.colour_later_s = offset_of(value, named)).has_value();
  if (key.text == "depth_bias") return (camera.depth_bias = bias_of(value, named)).has_value();
  if (key.text != "serial") {
    complain(key, fmt::format("unknown key '{}'; known are {}", key.text, fmt::join(kParts, ", ")));
    return false;
  }
  camera.serial = value.text;
  if (camera.serial.empty()) named(value, "expected the scanner's serial number");
  return !camera.serial.empty();
}

}  // namespace

std::optional<std::vector<double>> read_numbers(const YamlNode& node, std::size_t count,
                                                const YamlComplaint& complain) {
  if (node.kind != YamlNode::Kind::kSequence || node.children.size() != count) {
    complain(node, fmt::format("expected a list of {} numbers", count));
    return std::nullopt;
  }
  std::vector<double> numbers;
  for (const YamlNode& item : node.children) {
    const auto number = number_of(item, complain);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<Pose> read_pose(const YamlNode& node, const YamlComplaint& complain) {
  const auto numbers = read_numbers(node, 7, complain);
  if (!numbers) return std::nullopt;
  const std::vector<double>& n = *numbers;
  const Eigen::Quaterniond turn(n[6], n[3], n[4], n[5]);
  constexpr double kRounding = 1e-3;
  if (!(std::abs(turn.norm() - 1) <= kRounding)) {
    complain(node,
             fmt::format("expected tx, ty, tz, qx, qy, qz, qw with a quaternion of length 1, got {:.6g}", turn.norm()));
    return std::nullopt;
  }
  Pose pose(Eigen::Translation3d(n[0], n[1], n[2]));
  pose.rotate(turn.normalized());
  return pose;
}

std::optional<CameraModel> checked_camera(const CameraModel& model, const YamlNode& node,
                                          const YamlComplaint& complain) {
  const CameraIntrinsics& camera = model.intrinsics;
  if (camera.fx == 0 || camera.fy == 0) {
    complain(node, "fx and fy must not be 0");
    return std::nullopt;
  }
  if ((camera.width == 0) != (camera.height == 0)) {
    complain(node, "width and height: give both or neither");
    return std::nullopt;
  }
  return model;
}

std::optional<CameraModel> read_camera_map(const YamlNode& node, const YamlComplaint& complain) {
  CameraModel model;
  std::set<std::string> seen;
  bool is_good = read_entries(node, kCameraKeys, complain, [&](const YamlNode& key, const YamlNode& value) {
    seen.insert(key.text);
    return set_entry(model, key, value, complain);
  });
  if (!is_good) return std::nullopt;
  if (!seen.contains("intrinsic_matrix")) {
    for (const char* required : {"fx", "fy", "cx", "cy"}) {
      if (seen.contains(required)) continue;
      complain(node, fmt::format("'{}' is missing", required));
      is_good = false;
    }
  }
  return is_good ? checked_camera(model, node, complain) : std::nullopt;
}

bool is_scanner_camera(const YamlNode& root) {
  const auto is_part = [](const std::string& text) { return std::ranges::find(kParts, text) != kParts.end(); };
  return root.kind == YamlNode::Kind::kMap && !root.children.empty() && is_part(root.children.front().text);
}

std::optional<ScannerCamera> read_scanner_camera(const YamlNode& root, const YamlComplaint& complain) {
  ScannerCamera camera;
  const bool is_good =
      read_entries(root, fmt::format("{}", fmt::join(kParts, ", ")), complain,
                   [&](const YamlNode& key, const YamlNode& value) { return set_part(camera, key, value, complain); });
  if (!is_good) return std::nullopt;
  if (!camera.colour && !camera.depth) {
    complain(root, "expected colour: or depth:, as `calibrate camera` writes them");
    return std::nullopt;
  }
  if (camera.depth_bias && !camera.depth) {
    complain(root, "depth_bias belongs to a depth camera, expected depth: too");
    return std::nullopt;
  }
  return camera;
}

std::shared_ptr<const ScannerCamera> read_scanner_camera_file(const YamlNode& node, const std::filesystem::path& folder,
                                                              const YamlComplaint& complain) {
  if (node.kind != YamlNode::Kind::kScalar || node.text.empty()) {
    complain(node, "expected the name of a file that `calibrate camera` wrote");
    return nullptr;
  }
  const std::string path = (folder / node.text).string();  // an absolute path stays absolute
  const auto text = read_text_file(path, Limits{}.max_config_bytes);
  if (!text) {
    complain(node, text.error().text());
    return nullptr;
  }
  const auto parsed = parse_yaml(*text);
  if (const auto* error = std::get_if<YamlError>(&parsed)) {
    complain(node, fmt::format("{}:{}:{}: {}", path, error->line, error->column, error->message));
    return nullptr;
  }
  const auto complain_of_file = [&](const YamlNode& at, const std::string& what) {
    complain(node, fmt::format("{}:{}:{}: {}", path, at.line, at.column, what));
  };
  auto camera = read_scanner_camera(std::get<YamlNode>(parsed), complain_of_file);
  if (!camera) return nullptr;
  // From anywhere: a printed configuration may be read in another folder.
  camera->file = std::filesystem::absolute(path).lexically_normal().string();
  return std::make_shared<const ScannerCamera>(*std::move(camera));
}

}  // namespace scanknit
