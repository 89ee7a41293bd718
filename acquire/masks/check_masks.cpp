#include "acquire/masks/check_masks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <functional>
#include <optional>
#include <set>

namespace scanknit {
namespace {

constexpr double kMost = 0.75;

/// Counts the pixels of a mask that are the thing.
class Share {
 public:
  explicit Share(const AcquireConfig& config) : label_(config.mask_class), has_labels_(config.keeps_labels) {}

  void add(std::uint8_t value) {
    const bool is_thing = has_labels_ ? value > 0 : label_ ? value == *label_ : value >= kHalfOfMask;
    thing_ += is_thing ? 1 : 0;
    ++all_;
  }
  [[nodiscard]] bool is_none() const { return thing_ == 0; }
  [[nodiscard]] bool is_all() const { return thing_ == all_; }
  [[nodiscard]] double of_all() const { return all_ > 0 ? thing_ / all_ : 0; }

 private:
  std::optional<int> label_;
  bool has_labels_;
  double thing_ = 0, all_ = 0;
};

/// Of the pixels for which `is_counted(x, y)`.
Share share_of(const Mask& mask, const AcquireConfig& config, const std::function<bool(int, int)>& is_counted) {
  Share share(config);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (is_counted(x, y)) share.add(mask.at(x, y));
    }
  }
  return share;
}

bool is_inverted(const Mask& mask, const AcquireConfig& config) {
  const auto is_at_border = [&](int x, int y) {
    return x == 0 || y == 0 || x + 1 == mask.width() || y + 1 == mask.height();
  };
  const auto is_in_middle = [&](int x, int y) {
    return 3 * x >= mask.width() && 3 * x < 2 * mask.width() && 3 * y >= mask.height() && 3 * y < 2 * mask.height();
  };
  return share_of(mask, config, is_at_border).of_all() >= kMost &&
         share_of(mask, config, is_in_middle).of_all() <= 1 - kMost;
}

bool has_other_shape(const Mask& mask, int width, int height) {
  constexpr double kRounding = 0.02;
  const double across = static_cast<double>(mask.width()) * height;
  const double down = static_cast<double>(mask.height()) * width;
  return std::abs(across - down) > kRounding * down;
}

std::string text_of_empty(const Mask& mask, const AcquireConfig& config) {
  if (!config.mask_class) return "the mask is empty: nothing of this frame is fused; expected the thing to be white";
  const std::set<int> values(mask.pixels().begin(), mask.pixels().end());
  return fmt::format(
      "no pixel of the mask is {} (acquire.mask_class): nothing of this frame is fused; its values are {}",
      *config.mask_class, fmt::join(values, ", "));
}

/// Nothing: no fault.
std::optional<std::string> fault_of_contents(const Mask& mask, const AcquireConfig& config) {
  const Share share = share_of(mask, config, [](int, int) { return true; });
  if (share.is_none()) return text_of_empty(mask, config);
  if (config.keeps_labels) return std::nullopt;
  if (share.is_all()) return "all of the mask is the thing: nothing is left out";
  if (is_inverted(mask, config)) {
    return "the border of the mask is the thing and its middle is not: it is most likely inverted; expected the thing "
           "to be white (255) and all else black (0), or acquire.mask_class to be the thing's value";
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> mask_warnings(const std::vector<MaskFile>& masks, int depth_width, int depth_height,
                                       const AcquireConfig& config) {
  std::vector<std::string> warnings;
  std::set<std::string> kinds;
  const auto warn_once = [&](const std::string& fault, const std::filesystem::path& path) {
    constexpr std::size_t kEnoughToTell = 24;  // letters: messages of one kind begin alike
    if (kinds.insert(fault.substr(0, kEnoughToTell)).second) warnings.push_back(path.string() + ": " + fault);
  };
  for (const auto& [path, mask] : masks) {
    if (has_other_shape(mask, depth_width, depth_height)) {
      warn_once(fmt::format("the mask has another shape than the depth picture, {} x {} instead of {} x {}: it is "
                            "stretched; expected the same size, or the same ratio of its sides",
                            mask.width(), mask.height(), depth_width, depth_height),
                path);
    }
    if (const auto fault = fault_of_contents(mask, config)) warn_once(*fault, path);
  }
  return warnings;
}

}  // namespace scanknit
