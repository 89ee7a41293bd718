#include "app/config/rig_file.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "app/config/config_camera.h"
#include "app/config/yaml_node.h"
#include "core/files/quantity.h"
#include "core/files/read_file.h"
#include "core/limits.h"

namespace scanknit {
namespace {

constexpr const char* kRigCameraKeys = "recording, T_rig_camera, clock_offset_ms, camera";

/// Nanoseconds.
std::optional<std::int64_t> clock_of(const YamlNode& node, const YamlComplaint& complain) {
  constexpr double kMost_ms = 4e12;  // 127 years: a clock that counts from 1900
  const auto offset_ms = node.kind == YamlNode::Kind::kScalar ? parse_finite(node.text) : std::nullopt;
  if (offset_ms && std::abs(*offset_ms) <= kMost_ms) return std::llround(*offset_ms * 1e6);
  complain(node, fmt::format("clock_offset_ms: expected a number of milliseconds, got '{}'", node.text));
  return std::nullopt;
}

/// A CAMERA.yaml in the place of its name, or its name.
std::shared_ptr<const ScannerCamera> lens_of_rig_camera(const YamlNode& node, const std::filesystem::path& folder,
                                                        const YamlComplaint& complain) {
  if (node.kind != YamlNode::Kind::kMap) return read_scanner_camera_file(node, folder, complain);
  auto camera = read_scanner_camera(node, complain);
  return camera ? std::make_shared<const ScannerCamera>(*std::move(camera)) : nullptr;
}

/// False when it complained.
bool set_rig_entry(RigCamera& camera, const YamlNode& key, const YamlNode& value, const std::filesystem::path& folder,
                   const YamlComplaint& complain) {
  if (key.text == "recording") return true;
  if (key.text == "T_rig_camera") {
    const auto pose = read_pose(value, complain);
    if (pose) camera.T_rig_camera = *pose;
    return pose.has_value();
  }
  if (key.text == "clock_offset_ms") {
    const auto offset_ns = clock_of(value, complain);
    if (offset_ns) camera.clock_offset_ns = *offset_ns;
    return offset_ns.has_value();
  }
  if (key.text == "camera") return (camera.camera = lens_of_rig_camera(value, folder, complain)) != nullptr;
  complain(key, fmt::format("unknown key '{}'; known are {}", key.text, kRigCameraKeys));
  return false;
}

std::optional<RigCamera> rig_camera_of(const YamlNode& node, const std::filesystem::path& folder,
                                       const YamlComplaint& complain) {
  if (node.kind != YamlNode::Kind::kMap) {
    complain(node, fmt::format("expected a map of {}", kRigCameraKeys));
    return std::nullopt;
  }
  RigCamera camera;
  std::set<std::string> seen;
  for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
    const YamlNode& key = node.children[i];
    if (!seen.insert(key.text).second) {
      complain(key, fmt::format("duplicate key '{}'", key.text));
      return std::nullopt;
    }
    if (!set_rig_entry(camera, key, node.children[i + 1], folder, complain)) return std::nullopt;
  }
  if (seen.contains("T_rig_camera")) return camera;
  complain(node, "'T_rig_camera' is missing");
  return std::nullopt;
}

}  // namespace

Result<Rig> read_rig_file(const std::filesystem::path& path) {
  const auto text = read_text_file(path, Limits{}.max_config_bytes);
  if (!text) return text.error();
  std::optional<Error> fault;
  const auto refuse = [&](int line, int column, const std::string& message) {
    if (!fault) fault = Error{ErrorCode::kConfig, message, fmt::format("{}:{}:{}", path.string(), line, column)};
  };
  const auto complain = [&](const YamlNode& at, const std::string& what) { refuse(at.line, at.column, what); };
  const auto parsed = parse_yaml(*text);
  if (const auto* error = std::get_if<YamlError>(&parsed)) {
    refuse(error->line, error->column, error->message);
    return *fault;
  }
  const YamlNode& root = std::get<YamlNode>(parsed);
  const bool has_cameras = root.kind == YamlNode::Kind::kMap && root.children.size() == 2 &&
                           root.children[0].text == "cameras" && root.children[1].kind == YamlNode::Kind::kSequence &&
                           root.children[1].children.size() >= 2;
  if (!has_cameras) {
    refuse(root.line, root.column, "expected cameras: and a list of at least two, as `scanknit calibrate rig` writes");
    return *fault;
  }
  Rig rig;
  for (const YamlNode& node : root.children[1].children) {
    auto camera = rig_camera_of(node, path.parent_path(), complain);
    if (!camera) return *fault;
    rig.cameras.push_back(*std::move(camera));
  }
  return rig;
}

}  // namespace scanknit
