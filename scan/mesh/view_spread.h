// How far the mean of a place's views is from the truth, measured by how far the views are from each other.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/field_view.h"
#include "core/noise_model.h"
#include "export/picture/surface_fit.h"

namespace scanknit {

/// Compares views of one place with each other. Errors that differ from pixel to pixel average out; errors that change
/// slowly over the picture (lens, projector, registration) are common to views that see the place through neighbouring
/// pixels, and do not. Half of the mean squared difference of two views, by the distance of their pixels, is their
/// variogram (Matheron 1963, "Principles of Geostatistics", equation for gamma(h)). Its sill less the variogram is the
/// covariance of two views; from these follows the variance of the weighted mean of a place's views, which the
/// volume's weight there understates by a factor (Kish 1965, "Survey Sampling", the design effect).
class ViewSpread {
 public:
  ViewSpread(std::span<const PosedDepth> frames, const NoiseModel& noise);

  /// Takes the patches of the frames' pictures whose middle has its cell at begin_x <= x < end_x, index coordinates.
  /// Patches with a reading beyond the band, or in a cell that was not observed as a whole, do not count.
  void add(const FieldView& view, int begin_x = std::numeric_limits<int>::min(),
           int end_x = std::numeric_limits<int>::max());

  /// The standard deviation of a view of weight 1, metres: NoiseModel::floor_m times the root of the factor's median.
  /// With too few views of one place to tell, the floor. The same bits for any number of threads.
  [[nodiscard]] double view_sigma_m() const;

 private:
  /// A patch of kPatch x kPatch readings; sigma_m is 0 where there is none.
  struct Patch {
    Eigen::Vector3f p_world = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    float sigma_m = 0;  ///< of one reading at a right angle
    float facing = 0;   ///< cosine of the incidence
    float weight = 0;   ///< the volume's
  };
  struct Variogram;

  [[nodiscard]] std::size_t columns(std::size_t frame) const;
  [[nodiscard]] std::size_t rows(std::size_t frame) const;
  /// The patch of another frame that sees the same place; null when there is none.
  [[nodiscard]] const Patch* same_place(const Patch& patch, std::size_t frame, Eigen::Vector2d& pixel) const;
  [[nodiscard]] Variogram measure() const;

  std::span<const PosedDepth> frames_;
  NoiseModel noise_;
  float voxel_size_m_ = 0;
  std::vector<std::vector<Patch>> patches_;  ///< of each frame, row by row
};

}  // namespace scanknit
