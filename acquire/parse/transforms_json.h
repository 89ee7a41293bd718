// transforms.json of nerfstudio (docs.nerf.studio, "Data conventions") and instant-ngp: what recordings with depth and
// pictures without it have in common.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "acquire/acquire_config.h"
#include "core/axes.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

inline constexpr const char* kTransformsFile = "transforms.json";

/// A frame's key, else that of all frames; null: neither has it.
[[nodiscard]] const nlohmann::json* find_key(const nlohmann::json& frame, const nlohmann::json& all, const char* key);
[[nodiscard]] std::optional<double> find_number(const nlohmann::json& frame, const nlohmann::json& all,
                                                const char* key);
/// Empty: it is not there, or no text.
[[nodiscard]] std::string text_at(const nlohmann::json& frame, const char* key);

/// An object with a list of objects "frames". Errors (kInput) name the file.
[[nodiscard]] Result<nlohmann::json> read_transforms(const std::filesystem::path& path, const Limits& limits);

/// 3 or 4 rows of four numbers.
[[nodiscard]] std::optional<Eigen::Matrix4d> matrix_of(const nlohmann::json& rows);

/// What the file's writer did to the world: p_file = scale * T_file_world * p_world.
struct AppliedChange {
  Pose T_file_world = Pose::Identity();
  double scale = 1;

  [[nodiscard]] Pose undone(Pose T_file_camera) const;
  /// z is up in the file; this is the axis of the world that comes nearest to it.
  [[nodiscard]] UpAxis world_up() const;
};
[[nodiscard]] Result<AppliedChange> applied_change(const nlohmann::json& json, const std::filesystem::path& path);

/// The pose of a frame, its transform_matrix; nothing: it has none.
[[nodiscard]] std::optional<Result<Pose>> pose_of(const nlohmann::json& frame, const AppliedChange& change,
                                                  const std::filesystem::path& path);

/// A lens that a CameraModel can hold, of the picture of w x h pixels. The file counts pixels from the corner of the
/// first one, which is half a pixel before its centre.
[[nodiscard]] Result<CameraModel> camera_of(const nlohmann::json& frame, const nlohmann::json& all);

}  // namespace scanknit
