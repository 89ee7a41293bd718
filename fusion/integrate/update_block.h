// Integrates one frame into one block of 8^3 voxels: the inner loop of integration.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "core/image.h"
#include "core/pixels/pixel_rows.h"
#include "core/pose.h"
#include "core/voxel_codes.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/block_size.h"

namespace scanknit {

inline constexpr std::size_t kSlabVoxels = 64;  ///< voxels with the same x

/// The inner part of the band, which will contain the surface in spite of noise: only there colour is updated.
inline constexpr float kInnerBand = 0.5f;

/// The weight of free space in front of a surface, as a share of an observation's: enough to carve. Behind a surface
/// the largest distance times its weight is 0.105 truncations (a quarter of a truncation behind, times the cube of
/// three quarters): what was seen N times is free after about 2 N views through it.
inline constexpr float kFreeSpaceShare = 0.05f;

/// A colour is the mean of about so many views as good as the best one ...
inline constexpr float kColourViews = 8;
/// ... which is a view at a right angle from this range, metres.
inline constexpr float kBestColourRange = 0.4f;

/// A frame's colours in the form that the inner loop uses.
struct ColourView {
  const std::uint32_t* pixels = nullptr;  ///< codes of colours; null: the frame has no colours
  int width = 0, height = 0;
  float fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<float, 9> R{};  ///< T_colour_depth, row by row
  std::array<float, 3> t{};
  std::uint32_t seed = 0;  ///< different for every frame
};

/// The observation of a pixel for the voxels that project to it: a plane in camera coordinates, and its truncation
/// band. Sixteen bytes, read at once; values that need less precision use only the upper half of a float (a relative
/// error of 1/512), two in a word.
struct PixelPlane {
  float z_m;                                ///< where the pixel's ray meets the plane; 0: no surface
  float slope;                              ///< the normal times the ray, negative
  std::uint32_t per_u_and_per_v;            ///< change of the slope with each pixel; along u in the upper half
  std::uint32_t per_truncation_and_weight;  ///< 1 / truncation; cos(incidence) best_variance / sigma^2(z)
};
static_assert(sizeof(PixelPlane) == 16);

/// Homogeneous pixel coordinates: (z u, z v, z) of a point that projects to (u, v), metres.
using InPixels = std::array<float, 3>;

/// Where a block's first voxel is.
struct BlockPlace {
  InPixels first;
  float far_m;  ///< no pixel observes anything behind this z
};

/// Steps from a block's first voxel to the others, in one homogeneous pixel coordinate.
struct VoxelSteps {
  std::array<float, kBlockEdgeVoxels> slab;  ///< to the first of each x
  alignas(64) std::array<float, kSlabVoxels> in_slab;
};

/// The values that all blocks of a frame share, for the inner loop.
struct FrameView {
  FrameView(const Image<PixelPlane>& pixels, const CameraIntrinsics& camera, const Pose& T_camera_world,
            const FusionConfig& config);

  /// `first`: the index of a block's first voxel.
  [[nodiscard]] BlockPlace place(const Eigen::Vector3d& first, float far_m) const;

  std::array<VoxelSteps, 3> steps;
  const PixelPlane* planes;
  int width, height;
  float cx, cy;
  float per_fx, per_fy;
  float band_m;             ///< the band's least half-width
  float truncation_sigmas;  ///< and in standard deviations of the noise
  float max_weight;
  /// Known voxels nearer than this are free, independent of the weight of the surface behind them: see Observation.
  /// Null: no carving.
  const float* clear_m = nullptr;
  FloatNoise noise;
  float best_variance;  ///< as in Band
  ColourView colour;

 private:
  Eigen::Matrix3d index_to_pixels_;
  Eigen::Vector3d origin_in_pixels_;
};

/// Voxel n = 64 x + 8 y + z, as in a leaf of OpenVDB.
struct BlockVoxels {
  float* tsdf;
  WeightCode* weight;
  ColourCode* colour;
};

/// The changes of a block by a frame.
struct BlockChange {
  std::array<std::uint64_t, kBlockEdgeVoxels> observed{};  ///< voxels that the frame observes: word x, bit 8 y + z
  bool is_free = false;                                    ///< all voxels were observed, and each is free space now
  bool has_matter = false;                                 ///< one of them is behind a surface now
  bool has_colour = false;                                 ///< one of them got a colour
};

/// Updates the weighted running mean of signed distances (Curless & Levoy 1996). A voxel's observed distance is its
/// distance from the plane of the pixel to which it projects, positive in front. The weight is cos(incidence) /
/// sigma^2(z), times the cube of 1 - |distance| / truncation. The cube is there because a view measures the distance
/// from the surface that it sees, while another part may be nearer; the larger the distance, the more likely that is.
/// Near edges and behind thin parts such views would outvote the one that sees the nearest part. The weight is the same
/// on both sides, so that noise has no preferred direction; free space keeps kFreeSpaceShare. There is no observation
/// farther behind the pixel's plane than the truncation. Chooses the widest instructions of the processor at run time;
/// each operation is rounded as IEEE 754 says, none are fused, so all give the same bits.
///
/// A colour is a running mean, too, of the views about as good as the best one: its share falls with the fourth
/// power of cos(incidence) / z against the best view's. It is rounded with a dither: without it, eight bits stall,
/// because a mean that moves by less than half a step would not move.
///
/// Why the cube: see ScanKnit's rows of bench/compare.py, with other powers. On the turntable the first power doubles
/// the error; in the noisy desk scene the fourth adds a tenth.
void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change);

}  // namespace scanknit
