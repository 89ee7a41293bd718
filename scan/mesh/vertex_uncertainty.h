// The uncertainty of a mesh's vertices, from the weights of the volume that it was extracted from.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "core/field_view.h"
#include "core/mesh.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "export/picture/surface_fit.h"

namespace scanknit {

/// How noisy a view is, as a share of what the sensor's noise model says, once the noise that differs from pixel to
/// pixel has averaged out: patches of the frames' pictures are compared with the volume's surface. It is the median
/// over the patches of |mean of distance / sigma(z)|, over that of a normal distribution (so Birge 1932, "The
/// Calculation of Errors by the Method of Least Squares", scales the error of a weighted mean). Patches with a pixel
/// beyond the band, or in a cell that was not observed as a whole, do not count.
class NoiseShare {
 public:
  NoiseShare(std::span<const PosedDepth> frames, const NoiseModel& noise) : frames_(frames), noise_(noise) {}

  /// Takes the patches whose first reading has its cell at begin_x <= x < end_x, index coordinates.
  void add(const FieldView& view, int begin_x = std::numeric_limits<int>::min(),
           int end_x = std::numeric_limits<int>::max());

  /// With fewer than a hundred patches 1.
  [[nodiscard]] double value();

 private:
  std::span<const PosedDepth> frames_;
  NoiseModel noise_;
  std::vector<float> shares_;
};

/// What turns a weight into a standard deviation.
struct UncertaintyScale {
  double view_sigma_m = 0;  ///< of one view of weight 1: NoiseModel::floor_m times NoiseShare
  double voxel_size_m = 0;
};

/// Raises the weight of each vertex to the volume's there: the trilinear mean of the weights of its cell's samples, of
/// which those that were not observed count 0. `weights` is as long as the mesh has vertices. Views of parts of one
/// volume may follow each other: the part that has all of a vertex's cell gives the most. A view without weights
/// changes nothing. The same bits for any number of threads.
void raise_weights(const Mesh& mesh, const Pose& T_world_mesh, const FieldView& view, std::vector<float>& weights);

/// One standard deviation of a vertex's place along its normal, metres; NaN for a weight of 0. See
/// docs/formats.md#uncertainty for what it is made of and how well it holds.
[[nodiscard]] float uncertainty_m(float weight, const UncertaintyScale& scale);

/// uncertainty_m() of each.
[[nodiscard]] std::vector<float> uncertainties_m(const std::vector<float>& weights, const UncertaintyScale& scale);

}  // namespace scanknit
