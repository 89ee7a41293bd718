#include "fusion/track/ferns.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr std::size_t kFerns = 500;  // as in the paper
constexpr int kFewestCommon = kFerns / 5;

/// In [0, 1). std::uniform_real_distribution differs between standard libraries; mt19937 itself does not.
float unit(std::mt19937& random) {
  return static_cast<float>(random() >> 8) / 16777216.0f;  // 24 bits: exact in a float
}

}  // namespace

Ferns::Ferns(double typical_depth_m) {
  constexpr std::uint32_t kSeed = 2015;
  constexpr float kSpread = 2.0f;  // thresholds from a quarter to four times the typical depth, evenly by ratio
  std::mt19937 random(kSeed);
  ferns_.reserve(kFerns);
  for (std::size_t i = 0; i < kFerns; ++i) {
    Fern fern{};
    fern.x = unit(random);
    fern.y = unit(random);
    fern.depth_m = static_cast<float>(typical_depth_m) * std::exp2(kSpread * (2 * unit(random) - 1));
    fern.intensity = unit(random);
    ferns_.push_back(fern);
  }
}

FernCode Ferns::encode(const SurfaceLevel& picture) const {
  FernCode code;
  code.reserve(ferns_.size());
  for (const Fern& fern : ferns_) {
    const auto x = static_cast<int>(fern.x * static_cast<float>(picture.intrinsics.width));
    const auto y = static_cast<int>(fern.y * static_cast<float>(picture.intrinsics.height));
    const std::size_t pixel = picture.index(x, y);
    const float z_m = picture.z_m[pixel];
    const int outcome = (z_m > fern.depth_m ? 1 : 0) + (picture.intensity[pixel] > fern.intensity ? 2 : 0);
    code.push_back(z_m > 0 ? static_cast<std::uint8_t>(outcome) : kUnseen);
  }
  return code;
}

double dissimilarity(const FernCode& a, const FernCode& b) {
  SCANKNIT_CHECK(a.size() == b.size());
  int common = 0;
  int different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {  // no branches: the compiler makes vectors of it
    const int is_common = (a[i] != kUnseen ? 1 : 0) & (b[i] != kUnseen ? 1 : 0);
    common += is_common;
    different += is_common & (a[i] != b[i] ? 1 : 0);
  }
  return common < kFewestCommon ? 1.0 : static_cast<double>(different) / static_cast<double>(common);
}

}  // namespace scanknit
