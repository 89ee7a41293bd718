// acquire.intrinsics: the only key whose value is a list, a map or a file.
#pragma once

#include <filesystem>
#include <optional>

#include "acquire/acquire_config.h"
#include "app/config/config_camera.h"
#include "app/config/yaml_node.h"

namespace scanknit {

/// [fx, fy, cx, cy]; a map of width, height, fx, fy, cx, cy and distortion: [k1, k2, p1, p2, k3] (fx, fy, cx, cy
/// required; width and height both or neither); or the name of a file, relative to `folder`, with nine numbers of a 3x3
/// matrix, an Open3D camera_intrinsic.json, such a map, or what `calibrate camera` wrote, of which depth is taken.
/// Nothing when it called YamlComplaint.
[[nodiscard]] std::optional<CameraModel> read_intrinsics(const YamlNode& node, const std::filesystem::path& folder,
                                                         const YamlComplaint& complain);

}  // namespace scanknit
