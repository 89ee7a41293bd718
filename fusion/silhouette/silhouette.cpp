#include "fusion/silhouette/silhouette.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr int kFinestTile = 8;   // pixels
constexpr float kHalf = 127.5f;  // of a mask: the outline

bool has_only_two_values(const Image<std::uint8_t>& mask) {
  return std::all_of(mask.pixels().begin(), mask.pixels().end(),
                     [](std::uint8_t value) { return value == 0 || value == 255; });
}

/// By a Gaussian of `sigma` pixels, rows and then columns; the border's pixels go on beyond it.
Image<float> smoothed(const Image<float>& image, double sigma) {
  constexpr int kReach = 3;
  std::array<float, kReach + 1> weights{};
  double sum = 0;
  for (int k = -kReach; k <= kReach; ++k) sum += std::exp(-k * k / (2 * sigma * sigma));
  for (int k = 0; k <= kReach; ++k) {
    weights[static_cast<std::size_t>(k)] = static_cast<float>(std::exp(-k * k / (2 * sigma * sigma)) / sum);
  }
  const auto pass = [&](const Image<float>& from, bool along_rows) {
    Image<float> to(from.width(), from.height());
    tbb::parallel_for(0, from.height(), [&](int y) {
      for (int x = 0; x < from.width(); ++x) {
        float mean = 0;
        for (int k = -kReach; k <= kReach; ++k) {
          const int nx = along_rows ? std::clamp(x + k, 0, from.width() - 1) : x;
          const int ny = along_rows ? y : std::clamp(y + k, 0, from.height() - 1);
          mean += weights[static_cast<std::size_t>(std::abs(k))] * from.at(nx, ny);
        }
        to.at(x, y) = mean;
      }
    });
    return to;
  };
  return pass(pass(image, true), false);
}

/// Positive outside of the thing.
Image<float> level_of(const Image<std::uint8_t>& mask) {
  Image<float> level(mask.width(), mask.height());
  std::transform(mask.pixels().begin(), mask.pixels().end(), level.pixels().begin(),
                 [](std::uint8_t value) { return kHalf - static_cast<float>(value); });
  constexpr double kSigma_px = 0.7;
  return has_only_two_values(mask) ? smoothed(level, kSigma_px) : level;
}

struct Segment {
  Eigen::Vector2f a, b;

  [[nodiscard]] float squared_distance(const Eigen::Vector2f& p) const {
    const Eigen::Vector2f along = b - a;
    const float length = along.squaredNorm();
    const float share = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0f, 1.0f) : 0.0f;
    return (a + share * along - p).squaredNorm();
  }
};

/// The pieces of the outline between four pixels' centres (marching squares; the mean of the four decides where two
/// ways are possible).
class CellOutline {
 public:
  CellOutline(const Image<float>& level, int x, int y) {
    const std::array<float, 4> values{level.at(x, y), level.at(x + 1, y), level.at(x + 1, y + 1), level.at(x, y + 1)};
    const auto corner = [&](std::size_t k) {
      return Eigen::Vector2f(static_cast<float>(x + (k == 1 || k == 2 ? 1 : 0)),
                             static_cast<float>(y + (k >= 2 ? 1 : 0)));
    };
    std::array<Eigen::Vector2f, 4> crossings;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t next = (k + 1) % 4;
      if ((values[k] < 0) == (values[next] < 0)) continue;
      crossings[count++] = corner(k) + values[k] / (values[k] - values[next]) * (corner(next) - corner(k));
    }
    if (count == 2) add(crossings[0], crossings[1]);
    if (count != 4) return;
    const bool is_middle_inside = values[0] + values[1] + values[2] + values[3] < 0;
    const bool cuts_first_corner = is_middle_inside != (values[0] < 0);
    if (cuts_first_corner) {
      add(crossings[3], crossings[0]);
      add(crossings[1], crossings[2]);
    } else {
      add(crossings[0], crossings[1]);
      add(crossings[2], crossings[3]);
    }
  }

  [[nodiscard]] const Segment* begin() const { return segments_.data(); }
  [[nodiscard]] const Segment* end() const { return segments_.data() + count_; }

 private:
  void add(const Eigen::Vector2f& a, const Eigen::Vector2f& b) { segments_[count_++] = {a, b}; }

  std::array<Segment, 2> segments_;
  std::size_t count_ = 0;
};

}  // namespace

Silhouette::Silhouette(const Image<std::uint8_t>& mask, double reach_px)
    : width_(mask.width()), height_(mask.height()), reach_px_(reach_px) {
  SCANKNIT_CHECK(!mask.empty() && reach_px > 0 && reach_px <= kLongestReach_px);
  measure(level_of(mask));
  note_tiles();
  note_bounds();
}

void Silhouette::measure(const Image<float>& level) {
  const auto reach = static_cast<float>(reach_px_);
  Image<float> squared(width_, height_, reach * reach);
  std::vector<std::vector<Segment>> outline(static_cast<std::size_t>(height_));  // by the row where a segment begins
  tbb::parallel_for(0, height_ - 1, [&](int y) {
    for (int x = 0; x + 1 < width_; ++x) {
      for (const Segment& segment : CellOutline(level, x, y)) outline[static_cast<std::size_t>(y)].push_back(segment);
    }
  });
  const int around = static_cast<int>(std::ceil(reach_px_)) + 1;
  tbb::parallel_for(0, height_, [&](int y) {
    const auto row = squared.row(y);
    for (int from = std::max(0, y - around - 1); from <= std::min(height_ - 1, y + around); ++from) {
      for (const Segment& segment : outline[static_cast<std::size_t>(from)]) {
        const int middle = static_cast<int>(segment.a.x());
        for (int x = std::max(0, middle - around); x <= std::min(width_ - 1, middle + 1 + around); ++x) {
          float& nearest = row[static_cast<std::size_t>(x)];
          nearest = std::min(nearest, segment.squared_distance({static_cast<float>(x), static_cast<float>(y)}));
        }
      }
    }
  });
  distances_ = Image<Step>(width_, height_);
  std::transform(squared.pixels().begin(), squared.pixels().end(), level.pixels().begin(), distances_.pixels().begin(),
                 [](float distance, float side) {
                   const float signed_px = side < 0 ? -std::sqrt(distance) : std::sqrt(distance);
                   return static_cast<Step>(std::lrint(signed_px * kSteps));
                 });
}

void Silhouette::note_tiles() {
  const auto tiles_of = [](int pixels, int edge) { return (pixels + edge - 1) / edge; };
  Image<Tile> finest(tiles_of(width_, kFinestTile), tiles_of(height_, kFinestTile), Tile{32767, -32767});
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      Tile& tile = finest.at(x / kFinestTile, y / kFinestTile);
      tile.least = std::min(tile.least, distances_.at(x, y));
      tile.greatest = std::max(tile.greatest, distances_.at(x, y));
    }
  }
  tiles_.push_back(std::move(finest));
  while (tiles_.back().size() > 1) {
    const Image<Tile>& fine = tiles_.back();
    Image<Tile> coarse(tiles_of(fine.width(), 2), tiles_of(fine.height(), 2), Tile{32767, -32767});
    for (int y = 0; y < fine.height(); ++y) {
      for (int x = 0; x < fine.width(); ++x) {
        Tile& tile = coarse.at(x / 2, y / 2);
        tile.least = std::min(tile.least, fine.at(x, y).least);
        tile.greatest = std::max(tile.greatest, fine.at(x, y).greatest);
      }
    }
    tiles_.push_back(std::move(coarse));
  }
}

void Silhouette::note_bounds() {
  double sum_u = 0, sum_v = 0, count = 0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (distances_.at(x, y) >= 0) continue;
      const double u = x, v = y;
      if (!bounds_) bounds_ = OutlineRect{u, v, u, v};
      bounds_ = OutlineRect{std::min(bounds_->left, u), std::min(bounds_->top, v), std::max(bounds_->right, u),
                            std::max(bounds_->bottom, v)};
      sum_u += u;
      sum_v += v;
      ++count;
    }
  }
  if (count == 0) return;
  middle_u_ = sum_u / count;
  middle_v_ = sum_v / count;
}

std::optional<Silhouette::Range> Silhouette::range_px(const OutlineRect& rect) const {
  if (!sees(rect.left, rect.top) || !sees(rect.right, rect.bottom)) return std::nullopt;
  // The coarsest level in which the rectangle meets a few tiles only.
  std::size_t level = 0;
  const double longest = std::max(rect.right - rect.left, rect.bottom - rect.top);
  while (level + 1 < tiles_.size() && longest > (kFinestTile << level)) ++level;
  const int edge = kFinestTile << level;
  const auto next = [](double at, int size) { return std::min(static_cast<int>(at) + 1, size - 1); };
  const int last_x = next(rect.right, width_) / edge;
  const int last_y = next(rect.bottom, height_) / edge;
  Tile all{32767, -32767};
  for (int y = static_cast<int>(rect.top) / edge; y <= last_y; ++y) {
    for (int x = static_cast<int>(rect.left) / edge; x <= last_x; ++x) {
      const Tile& tile = tiles_[level].at(x, y);
      all.least = std::min(all.least, tile.least);
      all.greatest = std::max(all.greatest, tile.greatest);
    }
  }
  return Range{static_cast<float>(all.least) / kSteps, static_cast<float>(all.greatest) / kSteps};
}

}  // namespace scanknit
