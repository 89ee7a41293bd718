// The visual hull: carves a volume by the silhouettes of a thing in several pictures.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/silhouette/silhouette.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// One picture: where it was taken from, and what it shows.
struct SilhouetteView {
  CameraIntrinsics camera;  ///< of the silhouette's size
  Pose T_world_camera = Pose::Identity();
  Silhouette silhouette;
};

/// A box in the world that holds everything that no view sees outside of its silhouette, found on a coarse grid: a
/// little larger than the hull. Errors (kInput): fewer than two views; a view without the thing; views whose axes are
/// all parallel; silhouettes that have no point in common; views that bound the hull on some sides only.
[[nodiscard]] Result<Eigen::AlignedBox3d> hull_box(std::span<const SilhouetteView> views);

struct CarveStats {
  std::size_t blocks_added = 0;
  bool is_budget_reached = false;  ///< blocks were left out
};

/// Fills an empty volume with the visual hull within `box` (A. Laurentini 1994): at each voxel of the band the greatest
/// distance, over all views that see it, to the cone through the silhouette's outline: the distance in the picture
/// times depth over focal length. The weight is the count of these views. Voxels that fewer than two views see stay
/// unknown. The same bits for any number of threads. Errors: kBudget when the hull's surface has several times as many
/// blocks as fusion.memory_budget has room for; below that the volume is filled as far as there is room.
[[nodiscard]] Result<CarveStats> carve_hull(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box,
                                            TsdfVolume& volume);

/// The colours that one view gives: its picture, and which surface it sees.
struct ColourOfView {
  const ColourImage* picture = nullptr;
  CameraIntrinsics camera;  ///< of the picture
  Pose T_world_camera = Pose::Identity();
};

/// Paints the voxels beside the surface: the mean of the views that see it, those that look straight at it and from
/// near counting most, by the fourth power of cos(incidence)^2 / depth^2.
void paint_hull(std::span<const ColourOfView> views, TsdfVolume& volume);

/// How the outline of the volume and the view's own fit.
struct SilhouetteFit {
  double agreement = 0;  ///< share of the picture's pixels in which both are the same
  double overlap = 0;    ///< pixels that both have over pixels that one has
};
[[nodiscard]] SilhouetteFit compare_silhouette(const SilhouetteView& view, const TsdfVolume& volume);

}  // namespace scanknit
