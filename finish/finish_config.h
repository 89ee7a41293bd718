// FinishConfig: the finishing steps between fusing and writing. The keys of `finish:` in YAML.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/image.h"

namespace scanknit {

enum class Watertight {
  kOff,
  kSmall,  ///< close holes up to a size
  kFull,   ///< close the whole mesh, also where much must be invented
};

/// What to do with the table or the floor.
enum class GroundMode {
  kKeep,
  kRemove,  ///< remove it; what stood on it is open below
  kCap,     ///< remove it; a plane closes what stood on it
};

enum class UpMode {
  kWorld,   ///< the up axis of the recording or of export.world_up
  kGround,  ///< the normal of the table or the floor
};

enum class OriginMode {
  kKeep,
  kGround,  ///< on the ground, in the middle
};

/// Lower and upper limit along each axis, metres; nothing: no limit.
struct CropLimits {
  std::array<std::optional<double>, 3> low_m, high_m;

  [[nodiscard]] bool is_set() const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (low_m[axis] || high_m[axis]) return true;
    }
    return false;
  }
};

struct FinishConfig {
  CropLimits crop;                           ///< the recording's world
  GroundMode ground = GroundMode::kKeep;     ///< the table or the floor
  std::optional<double> ground_clearance_m;  ///< height of the cut above it; nothing: two voxels
  Watertight watertight = Watertight::kOff;
  double max_hole_m = 0.02;                ///< for Watertight::kSmall: the diagonal of a patch's bounding box
  std::optional<Rgb8> invented_colour;     ///< of closed holes; nothing: as their surroundings
  bool drops_crumbs = false;               ///< removes pieces that few frames saw
  double min_piece_share = 0;              ///< removes smaller pieces: share of the largest one's area
  double min_piece_size_m = 0;             ///< likewise: diagonal of the bounding box
  std::size_t smooth_steps = 0;            ///< pairs of Taubin's two passes
  std::optional<std::size_t> triangles;    ///< number of triangles after simplification
  std::optional<double> simplify_error_m;  ///< largest distance that simplification may move the surface
  UpMode up = UpMode::kWorld;
  OriginMode origin = OriginMode::kKeep;

  [[nodiscard]] bool needs_plane() const { return ground != GroundMode::kKeep || up == UpMode::kGround; }
  [[nodiscard]] bool changes_volume() const {
    return crop.is_set() || ground != GroundMode::kKeep || watertight != Watertight::kOff;
  }
  [[nodiscard]] bool is_anything() const {
    return changes_volume() || needs_plane() || min_piece_share > 0 || min_piece_size_m > 0 || smooth_steps > 0 ||
           triangles || simplify_error_m || origin != OriginMode::kKeep;
  }
};

}  // namespace scanknit
