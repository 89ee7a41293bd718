// acquire.camera: the file that `calibrate camera` writes; and the numbers of one camera.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "app/config/yaml_node.h"
#include "core/pose.h"

namespace scanknit {

/// Called for each error, with its place in the file.
using YamlComplaint = std::function<void(const YamlNode& where, const std::string& what)>;

// These give nothing (false, null) when they called YamlComplaint.

/// A list of `count` finite numbers.
[[nodiscard]] std::optional<std::vector<double>> read_numbers(const YamlNode& node, std::size_t count,
                                                              const YamlComplaint& complain);

/// [tx, ty, tz, qx, qy, qz, qw]: metres, and a quaternion of length 1.
[[nodiscard]] std::optional<Pose> read_pose(const YamlNode& node, const YamlComplaint& complain);

/// `model` if it can be a camera: fx and fy not 0, width and height both or neither.
[[nodiscard]] std::optional<CameraModel> checked_camera(const CameraModel& model, const YamlNode& node,
                                                        const YamlComplaint& complain);

/// A map of width, height, fx, fy, cx, cy and distortion: [k1, k2, p1, p2, k3]; fx, fy, cx, cy are required, or
/// Open3D's intrinsic_matrix.
[[nodiscard]] std::optional<CameraModel> read_camera_map(const YamlNode& node, const YamlComplaint& complain);

/// Whether the document is meant to be a CAMERA.yaml, by its first key.
[[nodiscard]] bool is_scanner_camera(const YamlNode& root);

/// CAMERA.yaml (docs/calibration.md): colour and depth, at least one; T_colour_depth: [tx, ty, tz, qx, qy, qz, qw] in
/// metres; time_offset_ms; depth_bias, only with depth; serial.
[[nodiscard]] std::optional<ScannerCamera> read_scanner_camera(const YamlNode& root, const YamlComplaint& complain);

/// The file that `node` names, relative to `folder`.
[[nodiscard]] std::shared_ptr<const ScannerCamera> read_scanner_camera_file(const YamlNode& node,
                                                                            const std::filesystem::path& folder,
                                                                            const YamlComplaint& complain);

}  // namespace scanknit
