#include "export/texture/atlas_packing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace scanknit {
namespace {

constexpr double kSlack = 1.06;  // what packing wastes, as a first guess of the width

/// Heights over the width: from `x` on as far as the next step.
struct Step {
  int x, y;
};

class Skyline {
 public:
  explicit Skyline(int width) : width_(width), steps_({{0, 0}}) {}

  /// Nothing when it is wider than the skyline.
  [[nodiscard]] std::optional<AtlasPlace> put(const AtlasBox& box) {
    std::optional<AtlasPlace> best;
    std::size_t best_step = 0;
    for (std::size_t i = 0; i < steps_.size() && steps_[i].x + box.width <= width_; ++i) {
      const int y = level(i, box.width, best ? best->y : INT32_MAX);
      if (best && y >= best->y) continue;
      best = AtlasPlace{steps_[i].x, y};
      best_step = i;
    }
    if (best) raise(best_step, box.width, best->y + box.height);
    return best;
  }

  [[nodiscard]] int height() const {
    return std::max_element(steps_.begin(), steps_.end(), [](auto& a, auto& b) { return a.y < b.y; })->y;
  }

 private:
  [[nodiscard]] int end_of(std::size_t i) const { return i + 1 < steps_.size() ? steps_[i + 1].x : width_; }

  /// The highest step under a box that begins at step `i`; stops looking at `enough`.
  [[nodiscard]] int level(std::size_t i, int box_width, int enough) const {
    const int end = steps_[i].x + box_width;
    int y = 0;
    for (; i < steps_.size() && steps_[i].x < end && y < enough; ++i) y = std::max(y, steps_[i].y);
    return y;
  }

  void raise(std::size_t first, int box_width, int y) {
    const int begin = steps_[first].x, end = begin + box_width;
    std::size_t last = first;  // the step that the box ends on
    while (end_of(last) < end) ++last;
    const Step rest{end, steps_[last].y};
    const bool leaves_rest = end_of(last) > end;
    const auto at = [this](std::size_t i) { return steps_.begin() + static_cast<std::ptrdiff_t>(i); };
    steps_.erase(at(first), at(last + 1));
    if (leaves_rest) steps_.insert(at(first), rest);
    steps_.insert(at(first), {begin, y});
  }

  int width_;
  std::vector<Step> steps_;
};

int multiple_of_four(double length) {
  return 4 * static_cast<int>(std::ceil(length / 4));
}

std::optional<Packing> pack_into(std::span<const AtlasBox> boxes, const std::vector<std::size_t>& order, int width) {
  Skyline skyline(width);
  Packing packing{width, 0, std::vector<AtlasPlace>(boxes.size())};
  for (const std::size_t i : order) {
    const auto place = skyline.put(boxes[i]);
    if (!place) return std::nullopt;
    packing.places[i] = *place;
  }
  packing.height = multiple_of_four(std::max(skyline.height(), 1));
  return packing;
}

}  // namespace

std::optional<Packing> pack_boxes(std::span<const AtlasBox> boxes, int max_side) {
  double area = 0;
  int widest = 1;
  for (const AtlasBox& box : boxes) {
    area += double{1} * box.width * box.height;
    widest = std::max(widest, box.width);
  }
  if (area > double{1} * max_side * max_side || widest > max_side) return std::nullopt;
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return boxes[a].height != boxes[b].height ? boxes[a].height > boxes[b].height : boxes[a].width > boxes[b].width;
  });
  const int guess = multiple_of_four(std::max(double{1} * widest, kSlack * std::sqrt(area)));
  for (int width = std::min(guess, max_side);; width = max_side) {
    auto packing = pack_into(boxes, order, width);
    if (packing && packing->height <= max_side) return packing;
    if (width == max_side) return std::nullopt;
  }
}

}  // namespace scanknit
