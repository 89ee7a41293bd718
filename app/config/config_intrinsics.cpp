#include "app/config/config_intrinsics.h"

#include <fmt/format.h>

#include <sstream>
#include <vector>

#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"
#include "core/files/read_file.h"
#include "core/limits.h"

namespace scanknit {
namespace {

constexpr const char* kExpected = "expected [fx, fy, cx, cy], a map with fx, fy, cx, cy, or the name of a file";

std::optional<CameraModel> from_list(const YamlNode& node, const YamlComplaint& complain) {
  const auto numbers = read_numbers(node, 4, complain);
  if (!numbers) return std::nullopt;
  return checked_camera({{0, 0, (*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]}, {}}, node, complain);
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

/// The depth camera of what `calibrate camera` wrote.
std::optional<CameraModel> depth_of(const YamlNode& root, const YamlComplaint& complain) {
  const auto camera = read_scanner_camera(root, complain);
  if (!camera) return std::nullopt;
  if (!camera->depth) {
    complain(root, "only the colour camera is calibrated, expected depth: too; calibrate pictures of the depth camera");
  }
  return camera->depth;
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
    return checked_camera({{0, 0, (*k)[0], (*k)[4], (*k)[2], (*k)[5]}, {}}, node, complain);
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
  return is_scanner_camera(*root) ? depth_of(*root, complain_of_file) : read_camera_map(*root, complain_of_file);
}

}  // namespace

std::optional<CameraModel> read_intrinsics(const YamlNode& node, const std::filesystem::path& folder,
                                           const YamlComplaint& complain) {
  switch (node.kind) {
    case YamlNode::Kind::kSequence: return from_list(node, complain);
    case YamlNode::Kind::kMap: return read_camera_map(node, complain);
    case YamlNode::Kind::kScalar: return from_file(node, folder, complain);
    case YamlNode::Kind::kNull: break;
  }
  complain(node, kExpected);
  return std::nullopt;
}

}  // namespace scanknit
