#include "app/config/config_intrinsics.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <sstream>
#include <string_view>
#include <vector>

#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"
#include "core/files/read_file.h"
#include "core/limits.h"

namespace scanknit {
namespace {

constexpr const char* kExpected = "expected [fx, fy, cx, cy], a map with fx, fy, cx, cy, or the name of a file";

std::optional<double> number_of(const YamlNode& node, const YamlComplaint& complain) {
  const auto number = node.kind == YamlNode::Kind::kScalar ? parse_finite(node.text) : std::nullopt;
  if (!number) complain(node, fmt::format("expected a number, got '{}'", node.text));
  return number;
}

std::optional<std::vector<double>> numbers_of(const YamlNode& node, std::size_t count, const YamlComplaint& complain) {
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

std::optional<CameraModel> accept(const CameraModel& model, const YamlNode& node, const YamlComplaint& complain) {
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

std::optional<CameraModel> from_list(const YamlNode& node, const YamlComplaint& complain) {
  const auto numbers = numbers_of(node, 4, complain);
  if (!numbers) return std::nullopt;
  return accept({{0, 0, (*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]}, {}}, node, complain);
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
    const auto numbers = numbers_of(value, model.distortion.size(), complain);
    if (numbers) std::copy(numbers->begin(), numbers->end(), model.distortion.begin());
    return numbers.has_value();
  }
  if (key.text == "intrinsic_matrix") {  // Open3D writes the 3x3 matrix column by column
    const auto matrix = numbers_of(value, 9, complain);
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
    complain(key, fmt::format("unknown key '{}'; known are width, height, fx, fy, cx, cy, distortion", key.text));
    return false;
  }
  const auto number = number_of(value, complain);
  if (number) *target = *number;
  return number.has_value();
}

std::optional<CameraModel> from_map(const YamlNode& node, const YamlComplaint& complain) {
  CameraModel model;
  std::set<std::string> seen;
  bool is_good = true;
  for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
    const YamlNode& key = node.children[i];
    if (!seen.insert(key.text).second) {
      complain(key, fmt::format("duplicate key '{}'", key.text));
      is_good = false;
    } else {
      is_good = set_entry(model, key, node.children[i + 1], complain) && is_good;
    }
  }
  if (!is_good) return std::nullopt;
  if (!seen.contains("intrinsic_matrix")) {
    for (const char* required : {"fx", "fy", "cx", "cy"}) {
      if (seen.contains(required)) continue;
      complain(node, fmt::format("'{}' is missing", required));
      is_good = false;
    }
  }
  return is_good ? accept(model, node, complain) : std::nullopt;
}

/// The nine numbers of "fx 0 cx / 0 fy cy / 0 0 1", separated by white space or commas. Nothing for any other text.
std::optional<std::vector<double>> matrix_text(std::string text) {
  for (char& c : text) {
    if (c == ',' || c == ';') c = ' ';
  }
  std::istringstream words(text);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const auto number = parse_finite(word);
    if (!number || numbers.size() == 9) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.size() != 9) return std::nullopt;
  return numbers;
}

/// What `scanknit calibrate camera` writes: a map for each camera.
bool is_calibration(const YamlNode& root) {
  return !root.children.empty() && (root.children.front().text == "colour" || root.children.front().text == "depth");
}

std::optional<CameraModel> from_calibration(const YamlNode& root, const YamlComplaint& complain) {
  std::optional<CameraModel> depth;
  for (std::size_t i = 0; i + 1 < root.children.size(); i += 2) {
    const YamlNode& key = root.children[i];
    const YamlNode& value = root.children[i + 1];
    const bool is_depth = key.text == "depth";
    if (!is_depth && key.text != "colour") {
      complain(key, fmt::format("unknown key '{}'; known are colour, depth", key.text));
      return std::nullopt;
    }
    if (value.kind != YamlNode::Kind::kMap || (is_depth && depth)) {
      complain(key, fmt::format("{}: expected one map of width, height, fx, fy, cx, cy, distortion", key.text));
      return std::nullopt;
    }
    const auto camera = from_map(value, complain);
    if (!camera) return std::nullopt;
    if (is_depth) depth = camera;
  }
  if (!depth) {
    complain(root, "only the colour camera is calibrated, expected depth: too; calibrate pictures of the depth camera");
  }
  return depth;
}

std::optional<CameraModel> from_file(const YamlNode& node, const std::filesystem::path& folder,
                                     const YamlComplaint& complain) {
  const std::filesystem::path path = folder / node.text;  // an absolute path stays absolute
  const auto text = read_text_file(path, Limits{}.max_config_bytes);
  if (!text) {
    complain(node, fmt::format("{}: {}", kExpected, text.error().text()));
    return std::nullopt;
  }
  if (const auto k = matrix_text(*text)) {
    return accept({{0, 0, (*k)[0], (*k)[4], (*k)[2], (*k)[5]}, {}}, node, complain);
  }
  const auto parsed = parse_yaml(*text);  // JSON is YAML
  const auto* root = std::get_if<YamlNode>(&parsed);
  if (root == nullptr || root->kind != YamlNode::Kind::kMap) {
    complain(node, path.string() + ": neither nine numbers, nor an Open3D camera_intrinsic.json, nor a YAML map");
    return std::nullopt;
  }
  const auto complain_of_file = [&](const YamlNode& at, const std::string& what) {
    complain(node, fmt::format("{}:{}:{}: {}", path.string(), at.line, at.column, what));
  };
  return is_calibration(*root) ? from_calibration(*root, complain_of_file) : from_map(*root, complain_of_file);
}

}  // namespace

std::optional<CameraModel> read_intrinsics(const YamlNode& node, const std::filesystem::path& folder,
                                           const YamlComplaint& complain) {
  switch (node.kind) {
    case YamlNode::Kind::kSequence: return from_list(node, complain);
    case YamlNode::Kind::kMap: return from_map(node, complain);
    case YamlNode::Kind::kScalar: return from_file(node, folder, complain);
    case YamlNode::Kind::kNull: break;
  }
  complain(node, kExpected);
  return std::nullopt;
}

}  // namespace scanknit
