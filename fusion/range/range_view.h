// RangeView: a range scan in the form that integration and tests of free space use.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/image.h"
#include "core/range_scan.h"
#include "core/voxel_codes.h"
#include "fusion/range/range_surface.h"

namespace scanknit {

/// A picture of the scan's surface along its lines of sight, regular in u and v for any grid. The triangles are drawn
/// into it; where two overlap, the nearer one counts. Between pixels, the nearest pixel's plane counts.
class RangeView {
 public:
  /// The surface along one line.
  struct Pixel {
    Eigen::Vector3f point = Eigen::Vector3f::Zero();   ///< on the surface, the scan's frame
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, towards the scanner
    float range_m = 0;                                 ///< of SightLines
    float slope = 0;                                   ///< cosine of the angle of incidence; 0: no surface
    float inset = 0;                                   ///< steps to the surface's rim, from 0 to 1 for kDeepest
    ColourCode colour = 0;                             ///< 0: none
  };

  RangeView(const RangeScan& scan, const RangeSurface& surface);

  [[nodiscard]] const SightLines& sight() const { return sight_; }
  [[nodiscard]] const Image<Pixel>& pixels() const { return pixels_; }

  /// The pixel nearest to a line; null outside of the picture, or if it has no surface.
  [[nodiscard]] const Pixel* at(const SightLines::Sight& sight) const {
    const auto place = place_of(sight);
    if (!place) return nullptr;
    const Pixel& pixel = pixels_.at(place->first, place->second);
    return pixel.slope > 0 ? &pixel : nullptr;
  }

  /// The surface in front of or behind `p` (the scan's frame), and the distance of `p` in front of it: positive in free
  /// space.
  struct Front {
    const Pixel* pixel;
    float distance_m;  ///< to the pixel's plane
    float before_m;    ///< along the line
  };
  /// Nothing if there is no surface along the line.
  [[nodiscard]] std::optional<Front> front_of(const Eigen::Vector3d& p) const;

  /// True if all lines of sight within kEmptyPixels of the one to `p` met nothing, although `p` is not farther away
  /// than other surfaces. Most likely, a surface at `p` that faces the scanner would have been seen. The directions of
  /// lines that met nothing come from the other lines of their row in the grid.
  [[nodiscard]] bool is_empty_around(const Eigen::Vector3d& p) const;
  static constexpr int kEmptyPixels = 3;

  /// The largest range of the surface.
  [[nodiscard]] float farthest_m() const { return farthest_m_; }

  /// The least `before_m` of the pixels within one pixel; nothing if one of them has no surface, because rims are
  /// unreliable.
  [[nodiscard]] std::optional<float> least_before_m(const Eigen::Vector3d& p) const;

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
  Image<std::uint8_t> is_empty_;  ///< for each of `pixels_`: a line there met nothing
  double first_u_ = 0, first_v_ = 0, step_u_ = 1, step_v_ = 1;
  float farthest_m_ = 0;
  bool wraps_around_ = false;  ///< the picture's last column is next to the first one
};

}  // namespace scanknit
