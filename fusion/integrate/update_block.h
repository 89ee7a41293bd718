// One frame enters one block of 8^3 voxels: the inner loop of integration.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "core/image.h"
#include "core/pixel_rows.h"
#include "core/pose.h"
#include "core/voxel_codes.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/block_size.h"

namespace scanknit {

inline constexpr std::size_t kSlabVoxels = 64;  ///< of one x

/// The inner part of the band, where the surface will come to lie whatever the noise: there colour is taken.
inline constexpr float kInnerBand = 0.5f;

/// Free space in front of a surface counts as much of an observation: enough to carve. Behind a surface the largest
/// distance times its weight is 0.105 truncations (a quarter of a truncation behind, times the cube of three quarters):
/// what was seen N times is free after about 2 N views through it.
inline constexpr float kFreeSpaceShare = 0.05f;

/// Colours are the mean of about so many views as good as the best one ...
inline constexpr float kColourViews = 8;
/// ... which is one at a right angle from this range, metres.
inline constexpr float kBestColourRange = 0.4f;

/// A frame's colours as the inner loop wants them.
struct ColourView {
  const std::uint32_t* pixels = nullptr;  ///< codes of colours; null: the frame has no colours
  int width = 0, height = 0;
  float fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<float, 9> R{};  ///< T_colour_depth, row by row
  std::array<float, 3> t{};
  std::uint32_t seed = 0;  ///< another one for every frame
};

/// What a pixel says of the voxels that project to it: in camera coordinates a plane, and the truncation band round it.
/// Sixteen bytes, which are read at once; what needs no more has the upper half of a float (a relative error of 1/512),
/// two in a word.
struct PixelPlane {
  float z_m;                                ///< where the pixel's ray meets the plane; 0: nothing seen
  float slope;                              ///< the normal times the ray, negative
  std::uint32_t per_u_and_per_v;            ///< what the slope grows by with each pixel; along u in the upper half
  std::uint32_t per_truncation_and_weight;  ///< 1 / truncation; cos(incidence) best_variance / sigma^2(z)
};
static_assert(sizeof(PixelPlane) == 16);

/// Homogeneous pixel coordinates: (z u, z v, z) of a point that projects to (u, v), metres.
using InPixels = std::array<float, 3>;

/// Where a block's first voxel is.
struct BlockPlace {
  InPixels first;
  float far_m;  ///< no pixel says anything of what lies behind this z
};

/// From a block's first voxel to the others, along one homogeneous pixel coordinate.
struct VoxelSteps {
  std::array<float, kBlockEdgeVoxels> slab;  ///< to the first of each x
  alignas(64) std::array<float, kSlabVoxels> in_slab;
};

/// What is the same for all blocks of a frame, as the inner loop wants it.
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
  /// Known voxels nearer than this are free, whatever the surface behind them weighs: see Observation. Null: not asked.
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

/// What a frame did to a block.
struct BlockChange {
  std::array<std::uint64_t, kBlockEdgeVoxels>
      observed{};           ///< voxels that the frame says something of: word x, bit 8 y + z
  bool is_free = false;     ///< all of them, and each is free space by now
  bool has_matter = false;  ///< one of them is behind a surface by now
  bool has_colour = false;  ///< one of them took a colour
};

/// Updates the weighted running mean of signed distances (Curless & Levoy 1996). A voxel that projects to a pixel is
/// at its distance to that pixel's plane, positive in front. How much this counts: cos(incidence) / sigma^2(z), times
/// the cube of 1 - |distance| / truncation. A view measures to the surface that it sees; another part may be nearer,
/// and the larger the distance, the likelier that is: near edges and behind thin parts such views would outvote the one
/// that sees the nearest part. On both sides alike, so that noise has no preferred direction; free space keeps
/// kFreeSpaceShare. Nothing is known beyond the truncation behind the pixel's plane. Chooses the widest instructions of
/// the processor at run time; each operation is rounded as IEEE 754 says, none are fused, so all give the same bits.
///
/// Colour is a running mean, too, of the views about as good as the best one: its share falls with the fourth power of
/// cos(incidence) / z against the best view's. Rounded with a dither, without which eight bits stall: a mean that moves
/// by less than half a step would not move.
///
/// Why the cube: ScanKnit's rows of bench/compare.py, with other powers here. On the turntable the first power doubles
/// the error; in the noisy desk scene the fourth adds a tenth.
void update_block(const FrameView& frame, const BlockPlace& place, const BlockVoxels& voxels, BlockChange& change);

}  // namespace scanknit
