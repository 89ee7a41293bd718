// render_preview: a picture of a mesh, without display or GPU.
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "core/axes.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// Four views in a 2 x 2 picture: three in colour from different sides, one shaded in grey. `world_up` stands upright.
/// With the pose of a scanner the first view and the grey one are what it saw, from where it looked. A mesh without
/// colours is shaded in all four.
[[nodiscard]] ColourImage render_preview(const Mesh& mesh, UpAxis world_up,
                                         const std::optional<Pose>& T_world_scanner = std::nullopt, int width = 1280,
                                         int height = 960);

/// The first two of those views side by side. `colours`: of the vertices, instead of the mesh's.
[[nodiscard]] ColourImage render_two_views(const Mesh& mesh, UpAxis world_up,
                                           const std::optional<Pose>& T_world_scanner,
                                           std::span<const Rgb8> colours = {});

/// Encodes as PNG and writes all or nothing.
[[nodiscard]] Result<void> write_png(const ColourImage& image, const std::filesystem::path& path);

}  // namespace scanknit
