#include "fusion/range/range_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/median.h"
#include "core/voxel_codes.h"

namespace scanknit {
namespace {

// The raster is drawn coarser where it would have more pixels than this: a few wild points must not cost the memory.
constexpr double kMostPixels = 64e6;
constexpr double kMostPixelsPerPoint = 16;
constexpr double kLongestSide = 1 << 16;

/// The difference of two u, the shorter way round.
double across(double from, double to, double period) {
  const double difference = to - from;
  return period > 0 ? difference - period * std::round(difference / period) : difference;
}

constexpr SightLines::Sight kNowhere{std::numeric_limits<double>::quiet_NaN(), 0, 0};

bool is_somewhere(const SightLines::Sight& sight) {
  return !std::isnan(sight.u);
}

Image<SightLines::Sight> sights_of(const RangeScan& scan) {
  Image<SightLines::Sight> sights(scan.points_m.width(), scan.points_m.height(), kNowhere);
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Eigen::Vector3f& p = scan.points_m.pixels()[i];
    if (!has_return(p)) continue;
    if (const auto sight = scan.sight.look(p.cast<double>())) sights.pixels()[i] = *sight;
  }
  return sights;
}

struct Span {
  double low, high;
};

/// From the least to the greatest value, but without strays: those that lie farther outside of 98 in 100 values than
/// these are apart. One such point would spread the raster over nothing.
Span span_without_strays(std::vector<double>& values) {
  const auto quantile = [&](std::size_t percent) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * percent / 100);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const Span all{*least, *greatest}, most{quantile(1), quantile(99)};
  const double apart = most.high - most.low;
  if (!(apart > 0)) return all;
  return {std::max(all.low, most.low - apart), std::min(all.high, most.high + apart)};
}

/// The first and the last whole number from `low` to `high` that is in [begin, end).
std::pair<int, int> whole_numbers(double low, double high, double begin, double end) {
  return {static_cast<int>(std::clamp(std::ceil(low), begin, end)),
          static_cast<int>(std::clamp(std::floor(high), begin - 1, end - 1))};
}

}  // namespace

RangeView::RangeView(const RangeScan& scan, const RangeSurface& surface) : sight_(scan.sight) {
  const Image<SightLines::Sight> sights = sights_of(scan);
  choose_raster(sights, scan.points_m);
  note_empty_lines(sights);
  for (const Triangle& triangle : surface.triangles) draw(scan, surface, sights, triangle);
  farthest_m_ = std::numeric_limits<float>::lowest();
  for (const Pixel& pixel : pixels_.pixels()) {
    if (pixel.slope > 0) farthest_m_ = std::max(farthest_m_, pixel.range_m);
  }
}

void RangeView::choose_raster(const Image<SightLines::Sight>& sights, const Image<Eigen::Vector3f>& points) {
  const double period = sight_.period_u();
  std::array<std::vector<double>, 4> steps;  // of u and v along rows, of u and v along columns
  std::vector<double> all_u, all_v;
  for (int y = 0; y < points.height(); ++y) {
    for (int x = 0; x < points.width(); ++x) {
      const SightLines::Sight& own = sights.at(x, y);
      if (!is_somewhere(own)) continue;
      all_u.push_back(own.u);
      all_v.push_back(own.v);
      const auto note = [&](int nx, int ny, std::size_t first) {
        if (nx < 0 || ny < 0 || !is_somewhere(sights.at(nx, ny))) return;
        steps[first].push_back(std::abs(across(sights.at(nx, ny).u, own.u, period)));
        steps[first + 1].push_back(std::abs(own.v - sights.at(nx, ny).v));
      };
      note(x - 1, y, 0);
      note(x, y - 1, 2);
    }
  }
  if (all_u.empty()) return;
  const auto [low_u, high_u] = span_without_strays(all_u);
  const auto [low_v, high_v] = span_without_strays(all_v);
  step_u_ = std::max(median(steps[0]), median(steps[2]));
  step_v_ = std::max(median(steps[1]), median(steps[3]));
  if (!(step_u_ > 0) || !(step_v_ > 0)) return;
  step_u_ = std::max(step_u_, (high_u - low_u) / kLongestSide);
  step_v_ = std::max(step_v_, (high_v - low_v) / kLongestSide);
  const double pixels = ((high_u - low_u) / step_u_ + 3) * ((high_v - low_v) / step_v_ + 3);
  const double most = std::min(kMostPixels, kMostPixelsPerPoint * static_cast<double>(points.size()));
  if (pixels > most) {
    step_u_ *= std::sqrt(pixels / most);
    step_v_ *= std::sqrt(pixels / most);
  }
  wraps_around_ = period > 0 && high_u - low_u > period - 4 * step_u_;
  int width = static_cast<int>((high_u - low_u) / step_u_) + 3;
  if (wraps_around_) {
    width = std::max(1, static_cast<int>(period / step_u_));
    step_u_ = period / width;
  }
  first_u_ = low_u - (wraps_around_ ? 0 : step_u_);
  first_v_ = low_v - step_v_;
  pixels_ = Image<Pixel>(width, static_cast<int>((high_v - low_v) / step_v_) + 3);
}

RangeView::Pixel RangeView::shade(const RangeScan& scan, const RangeSurface& surface,
                                  const Image<SightLines::Sight>& sights, const Triangle& triangle,
                                  const std::array<double, 3>& share) const {
  Pixel pixel;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double range = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t at = triangle[k];
    const auto part = static_cast<float>(share[k]);
    point += share[k] * scan.points_m.pixels()[at].cast<double>();
    pixel.normal += part * surface.normals.pixels()[at];
    pixel.inset += part * static_cast<float>(surface.inset.pixels()[at]) / RangeSurface::kDeepest;
    range += share[k] * sights.pixels()[at].range_m;
  }
  pixel.point = point.cast<float>();
  pixel.normal.normalize();
  pixel.range_m = static_cast<float>(range);
  pixel.slope = static_cast<float>(-sight_.direction(point).dot(pixel.normal.cast<double>()));
  const auto nearest = static_cast<std::size_t>(std::max_element(share.begin(), share.end()) - share.begin());
  if (!scan.colours.empty()) pixel.colour = encode_colour(scan.colours.pixels()[triangle[nearest]], 1);
  return pixel;
}

void RangeView::note_empty_lines(const Image<SightLines::Sight>& sights) {
  constexpr double kFewest = 8;  // lines of a row that say where its others are
  is_empty_ = Image<std::uint8_t>(pixels_.width(), pixels_.height());
  for (int y = 0; y < sights.height() && !pixels_.empty(); ++y) {
    double n = 0, x_sum = 0, xx = 0, u_sum = 0, xu = 0, v_sum = 0, xv = 0, start_u = 0;
    int first = 0, last = 0;
    for (int x = 0; x < sights.width(); ++x) {
      const SightLines::Sight& own = sights.at(x, y);
      if (!is_somewhere(own)) continue;
      if (n == 0) {
        first = x;
        start_u = own.u;
      }
      last = x;
      const double u = across(start_u, own.u, sight_.period_u());
      n += 1;
      x_sum += x;
      xx += double{1} * x * x;
      u_sum += u;
      xu += x * u;
      v_sum += own.v;
      xv += x * own.v;
    }
    const double spread = n * xx - x_sum * x_sum;
    if (n < kFewest || !(spread > 0)) continue;
    const double slope_u = (n * xu - x_sum * u_sum) / spread;
    const double slope_v = (n * xv - x_sum * v_sum) / spread;
    // Rows are straight for a while only: not farther than the seen part is long.
    const int reach = last - first;
    for (int x = std::max(0, first - reach); x < std::min(sights.width(), last + reach + 1); ++x) {
      if (is_somewhere(sights.at(x, y))) continue;
      const double off = x - x_sum / n;
      const auto place = place_of({start_u + u_sum / n + slope_u * off, v_sum / n + slope_v * off, 0});
      if (place) is_empty_.at(place->first, place->second) = 1;
    }
  }
}

void RangeView::draw(const RangeScan& scan, const RangeSurface& surface, const Image<SightLines::Sight>& sights,
                     const Triangle& triangle) {
  if (pixels_.empty()) return;
  std::array<Eigen::Vector2d, 3> at;
  for (std::size_t k = 0; k < 3; ++k) {
    const SightLines::Sight& sight = sights.pixels()[triangle[k]];
    if (!is_somewhere(sight)) return;
    const double u =
        k == 0 ? sight.u
               : sights.pixels()[triangle[0]].u + across(sights.pixels()[triangle[0]].u, sight.u, sight_.period_u());
    at[k] = {(u - first_u_) / step_u_, (sight.v - first_v_) / step_v_};
  }
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  if (!(std::abs(area) > 1e-9)) return;
  const Eigen::Vector2d low = at[0].cwiseMin(at[1]).cwiseMin(at[2]);
  const Eigen::Vector2d high = at[0].cwiseMax(at[1]).cwiseMax(at[2]);
  constexpr double kOnEdge = -1e-9;  // pixels on a common edge belong to both triangles
  const int turn = wraps_around_ ? pixels_.width() : 0;
  const auto [first_y, last_y] = whole_numbers(low.y(), high.y(), 0, pixels_.height());
  const auto [first_x, last_x] = whole_numbers(low.x(), high.x(), -turn, pixels_.width() + turn);
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      const Eigen::Vector2d p(x, y);
      const double b = cross(p - at[0], at[2] - at[0]) / area;
      const double c = cross(at[1] - at[0], p - at[0]) / area;
      const std::array<double, 3> share{1 - b - c, b, c};
      if (share[0] < kOnEdge || share[1] < kOnEdge || share[2] < kOnEdge) continue;
      const int column = wraps_around_ ? (x % pixels_.width() + pixels_.width()) % pixels_.width() : x;
      if (!pixels_.contains(column, y)) continue;
      const Pixel drawn = shade(scan, surface, sights, triangle, share);
      Pixel& pixel = pixels_.at(column, y);
      const bool is_hidden = pixel.slope > 0 && pixel.range_m <= drawn.range_m;
      if (drawn.slope > 0 && !is_hidden) pixel = drawn;
    }
  }
}

std::optional<std::pair<int, int>> RangeView::place_of(const SightLines::Sight& sight) const {
  double u = sight.u - first_u_;
  if (wraps_around_) u -= sight_.period_u() * std::floor(u / sight_.period_u());
  const double x = std::floor(u / step_u_ + 0.5);
  const double y = std::floor((sight.v - first_v_) / step_v_ + 0.5);
  if (!(x >= 0) || !(y >= 0) || !(x <= pixels_.width()) || !(y < pixels_.height())) return std::nullopt;
  const int column = static_cast<int>(x);
  if (column == pixels_.width() && !wraps_around_) return std::nullopt;
  return std::pair(column == pixels_.width() ? 0 : column, static_cast<int>(y));
}

std::optional<RangeView::Front> RangeView::front_of(const Eigen::Vector3d& p) const {
  const auto sight = sight_.look(p);
  if (!sight) return std::nullopt;
  const Pixel* pixel = at(*sight);
  if (pixel == nullptr) return std::nullopt;
  const double distance = pixel->normal.cast<double>().dot(p - pixel->point.cast<double>());
  return Front{pixel, static_cast<float>(distance), static_cast<float>(pixel->range_m - sight->range_m)};
}

bool RangeView::is_empty_around(const Eigen::Vector3d& p) const {
  const auto sight = sight_.look(p);
  if (!sight || sight->range_m > farthest_m_) return false;
  const auto place = place_of(*sight);
  if (!place) return false;
  int empty = 0;
  for (int dy = -kEmptyPixels; dy <= kEmptyPixels; ++dy) {
    for (int dx = -kEmptyPixels; dx <= kEmptyPixels; ++dx) {
      const int x = place->first + dx;
      const int y = place->second + dy;
      if (!pixels_.contains(x, y)) continue;
      if (pixels_.at(x, y).slope > 0) return false;
      empty += is_empty_.at(x, y);
    }
  }
  constexpr int kSide = 2 * kEmptyPixels + 1;
  return 2 * empty > kSide * kSide;
}

std::optional<float> RangeView::least_before_m(const Eigen::Vector3d& p) const {
  const auto sight = sight_.look(p);
  if (!sight) return std::nullopt;
  const auto place = place_of(*sight);
  if (!place) return std::nullopt;
  float least = std::numeric_limits<float>::max();
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!pixels_.contains(place->first + dx, place->second + dy)) return std::nullopt;
      const Pixel& pixel = pixels_.at(place->first + dx, place->second + dy);
      if (!(pixel.slope > 0)) return std::nullopt;
      least = std::min(least, pixel.range_m - static_cast<float>(sight->range_m));
    }
  }
  return least;
}

}  // namespace scanknit
