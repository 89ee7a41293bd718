// RangeView: a range scan as integration and tests of free space read it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/image.h"
#include "core/range_scan.h"
#include "core/voxel_codes.h"
#include "fusion/integrate/range_surface.h"

namespace scanknit {

/// A picture of the scan's surface along its lines of sight, regular in u and v whatever the grid was: triangles are
/// drawn, the nearer one where two overlap. What lies between pixels is at the nearest pixel's plane.
class RangeView {
 public:
  /// What is seen along one line.
  struct Pixel {
    Eigen::Vector3f point = Eigen::Vector3f::Zero();   ///< on the surface, the scan's frame
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, towards the scanner
    float range_m = 0;                                 ///< of SightLines
    float slope = 0;                                   ///< cosine of the angle of incidence; 0: nothing is seen
    float inset = 0;                                   ///< steps to the surface's rim, from 0 to 1 for kDeepest
    ColourCode colour = 0;                             ///< 0: none
  };

  RangeView(const RangeScan& scan, const RangeSurface& surface);

  [[nodiscard]] const SightLines& sight() const { return sight_; }
  [[nodiscard]] const Image<Pixel>& pixels() const { return pixels_; }

  /// The pixel nearest to a line; null outside of the picture, or where nothing is seen.
  [[nodiscard]] const Pixel* at(const SightLines::Sight& sight) const {
    const auto place = place_of(sight);
    if (!place) return nullptr;
    const Pixel& pixel = pixels_.at(place->first, place->second);
    return pixel.slope > 0 ? &pixel : nullptr;
  }

  /// The surface before or behind `p` (the scan's frame), and how far before it: positive in free space.
  struct Front {
    const Pixel* pixel;
    float distance_m;  ///< to the pixel's plane
    float before_m;    ///< along the line
  };
  /// Nothing where nothing is seen along the line.
  [[nodiscard]] std::optional<Front> front_of(const Eigen::Vector3d& p) const;

  /// True where lines of sight all round the one to `p`, kEmptyPixels to each side, met nothing at all, though `p` is
  /// not farther away than other things that are seen. A surface there that faces the scanner would have been seen,
  /// most likely. Lines that met nothing are where the others of their row in the grid say.
  [[nodiscard]] bool sees_nothing_round(const Eigen::Vector3d& p) const;
  static constexpr int kEmptyPixels = 3;

  /// The least `before_m` of the pixels within one of it; nothing where one of them sees nothing: rims tell little.
  [[nodiscard]] std::optional<float> surely_before(const Eigen::Vector3d& p) const;

 private:
  [[nodiscard]] std::optional<std::pair<int, int>> place_of(const SightLines::Sight& sight) const;
  void choose_raster(const Image<SightLines::Sight>& sights, const Image<Eigen::Vector3f>& points);
  void note_empty_lines(const Image<SightLines::Sight>& sights);
  [[nodiscard]] Pixel shade(const RangeScan& scan, const RangeSurface& surface, const Image<SightLines::Sight>& sights,
                            const Triangle& triangle, const std::array<double, 3>& share) const;
  void draw(const RangeScan& scan, const RangeSurface& surface, const Image<SightLines::Sight>& sights,
            const Triangle& triangle);

  SightLines sight_;
  Image<Pixel> pixels_;
  Image<std::uint8_t> is_empty_;  ///< as `pixels_`: a line was there that met nothing
  double first_u_ = 0, first_v_ = 0, step_u_ = 1, step_v_ = 1;
  float farthest_m_ = 0;     ///< range of what is seen
  bool goes_round_ = false;  ///< the picture's last column has the first one beside it
};

}  // namespace scanknit
