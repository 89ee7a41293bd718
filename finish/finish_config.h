// FinishConfig: what is done to a scan between fusing and writing. The keys of `finish:` in YAML.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/image.h"

namespace scanknit {

enum class Watertight {
  kOff,
  kSmall,  ///< holes up to a size are closed
  kFull,   ///< the mesh is closed, whatever has to be invented
};

/// What becomes of the table or the floor.
enum class GroundWish {
  kKeep,
  kRemove,  ///< left out; what stood on it is open below
  kCap,     ///< left out; what stood on it is closed by a plane
};

enum class UpWish {
  kWorld,   ///< as the recording or export.world_up says
  kGround,  ///< across the table or the floor
};

enum class OriginWish {
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
  GroundWish ground = GroundWish::kKeep;     ///< the table or the floor
  std::optional<double> ground_clearance_m;  ///< cut so far above it; nothing: two voxels
  Watertight watertight = Watertight::kOff;
  double max_hole_m = 0.02;                ///< what Watertight::kSmall closes: the diagonal of the patch's bounding box
  std::optional<Rgb8> invented_colour;     ///< of what was closed; nothing: as its surroundings
  double min_piece_share = 0;              ///< smaller pieces are left out: share of the largest one's area
  double min_piece_size_m = 0;             ///< likewise: diagonal of the bounding box
  std::size_t smooth_steps = 0;            ///< pairs of Taubin's two passes
  std::optional<std::size_t> triangles;    ///< simplified to so many
  std::optional<double> simplify_error_m;  ///< simplified as far as the surface moves by no more
  UpWish up = UpWish::kWorld;
  OriginWish origin = OriginWish::kKeep;

  [[nodiscard]] bool needs_plane() const { return ground != GroundWish::kKeep || up == UpWish::kGround; }
  [[nodiscard]] bool changes_volume() const {
    return crop.is_set() || ground != GroundWish::kKeep || watertight != Watertight::kOff;
  }
  [[nodiscard]] bool is_anything() const {
    return changes_volume() || needs_plane() || min_piece_share > 0 || min_piece_size_m > 0 || smooth_steps > 0 ||
           triangles || simplify_error_m || origin != OriginWish::kKeep;
  }
};

}  // namespace scanknit
