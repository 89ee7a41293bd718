// The module libscanknit_masks_opencv.so.
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>

#include "acquire/masks/masks_opencv.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr int kMostSide_px = 640;  // of the picture that is cut: the graph's work grows faster than its pixels
constexpr int kRounds = 5;
constexpr std::uint64_t kSeed = 1;  // of the first guess of the colours

cv::Mat smaller(const ColourImage& picture) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3,
                    const_cast<Rgb8*>(picture.pixels().data()));  // NOLINT: is only read
  const double times = std::min(1.0, static_cast<double>(kMostSide_px) / std::max(rgb.cols, rgb.rows));
  cv::Mat small;
  cv::resize(rgb, small, {}, times, times, cv::INTER_AREA);
  return small;
}

std::optional<Mask> grab_cut(const ColourImage& picture, double rim_share) {
  try {
    const cv::Mat small = smaller(picture);
    const int across = std::max(1, static_cast<int>(std::lround(rim_share * small.cols)));
    const int down = std::max(1, static_cast<int>(std::lround(rim_share * small.rows)));
    const cv::Rect within(across, down, small.cols - 2 * across, small.rows - 2 * down);
    if (within.width < 8 || within.height < 8) return std::nullopt;
    cv::theRNG().state = kSeed;
    cv::Mat labels, background, thing;
    cv::grabCut(small, labels, within, background, thing, kRounds, cv::GC_INIT_WITH_RECT);
    const cv::Mat hard = (labels & 1) * 255;  // GC_FGD and GC_PR_FGD are odd
    Mask mask(picture.width(), picture.height());
    cv::Mat whole(mask.height(), mask.width(), CV_8UC1, mask.pixels().data());
    cv::resize(hard, whole, whole.size(), 0, 0, cv::INTER_LINEAR);
    return mask;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr MasksOpenCv kOffers{grab_cut};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  cv::ocl::setUseOpenCL(false);
  return &kEntry;
}
