// SurfaceFit: how well a mesh agrees with depth frames, and which part of it they saw.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/axes.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/noise_model.h"
#include "core/pose.h"

namespace scanknit {

/// A depth frame where it was taken. Refers to the picture.
struct PosedDepth {
  const DepthImage* depth_m = nullptr;
  CameraIntrinsics intrinsics;  ///< of the picture
  Pose T_world_camera = Pose::Identity();
};

/// A reading farther from the surface than this is of something else: in front of it, or behind.
struct FitBand {
  double least_m = 0.016;
  double sigmas = 3;  ///< of `noise` at the reading's depth, where that is more
  NoiseModel noise;
};

struct SurfaceFit {
  std::size_t frames = 0;
  std::vector<std::uint16_t> seen_by;  ///< frames that have a reading of each vertex
  std::vector<float> error_m;          ///< mean distance of those readings from the surface; 0 where there are none
  double seen_share = 0;               ///< of the vertices
  double median_m = 0, p95_m = 0;      ///< of the errors of vertices that were seen; 0 without any
};

/// A reading belongs to a vertex when the pixel that the vertex falls on lies within the band along the vertex's
/// normal, and the camera is before the surface. Its distance is from the surface's tangent plane: pixels need not meet
/// vertices. The mesh must have normals. At most 65,535 frames. The same bits for any number of threads.
[[nodiscard]] SurfaceFit fit_surface(const Mesh& mesh, std::span<const PosedDepth> frames, const FitBand& band);

/// Numbers as colours: the least first, the most last, mixed between.
inline constexpr Rgb8 kErrorRamp[] = {{38, 70, 160}, {60, 170, 180}, {245, 215, 80}, {214, 48, 39}};
inline constexpr Rgb8 kCoverageRamp[] = {{214, 48, 39}, {245, 215, 80}, {60, 170, 120}, {20, 90, 130}};
inline constexpr Rgb8 kUnseenColour{150, 130, 150};

/// The end of a scale up to about `most_m`: rounded up to 1, 2 or 5 times a power of ten; at least a micrometre.
[[nodiscard]] double rounded_scale_end_m(double most_m);
/// The error that has the last colour: the 95th percentile, rounded up to 1, 2 or 5 times a power of ten; > 0.
[[nodiscard]] double error_map_end_m(const SurfaceFit& fit);
/// The count of frames that has the last colour: the largest, at least 1.
[[nodiscard]] std::size_t coverage_map_end(const SurfaceFit& fit);

/// Two views side by side, those of render_preview()'s first row, in the colours of the error, or of the coverage.
[[nodiscard]] ColourImage draw_error_map(const Mesh& mesh, const SurfaceFit& fit, UpAxis world_up,
                                         const std::optional<Pose>& T_world_scanner);
[[nodiscard]] ColourImage draw_coverage_map(const Mesh& mesh, const SurfaceFit& fit, UpAxis world_up,
                                            const std::optional<Pose>& T_world_scanner);

}  // namespace scanknit
