#include "fusion/register/scene_change.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/image.h"
#include "fusion/register/contradiction.h"

namespace scanknit {
namespace {

constexpr double kNearest_m = 0.01;

enum class Seen : std::uint8_t { kNothing, kSame, kNearer, kFarther };

Image<Seen> compare(const SurfaceLevel& frame, const SurfaceLevel& model, const Pose& T_model_frame,
                    const SteadyMotion& rows, const NoiseModel& noise) {
  const CameraIntrinsics& from = frame.intrinsics;
  const CameraIntrinsics& to = model.intrinsics;
  Image<Seen> seen(from.width, from.height, Seen::kNothing);
  tbb::parallel_for(0, from.height, [&](int y) {
    const Pose T_model_row = rows.is_still() ? T_model_frame : T_model_frame * pose_of_row(rows, y, from.height);
    for (int x = 0; x < from.width; ++x) {
      const double z_m = frame.z_m[frame.index(x, y)];
      if (!(z_m > 0)) continue;
      const Eigen::Vector3d p = T_model_row * from.unproject(x, y, z_m);
      if (!(p.z() > kNearest_m)) continue;
      const Eigen::Vector2d pixel = to.project(p) + Eigen::Vector2d(0.5, 0.5);
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < to.width && pixel.y() < to.height)) continue;
      const double model_m = model.z_m[model.index(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))];
      if (!(model_m > 0)) continue;
      const double farther_m = p.z() - model_m;
      const bool is_same = std::abs(farther_m) <= contradiction_m(noise, z_m);
      seen.at(x, y) = is_same ? Seen::kSame : farther_m > 0 ? Seen::kFarther : Seen::kNearer;
    }
  });
  return seen;
}

/// Whether a square of this side, of which (x, y) is the upper left, shows nothing but `what`.
bool is_full(const Image<Seen>& seen, int x, int y, int side, Seen what) {
  for (int row = y; row < y + side; ++row) {
    const auto pixels = seen.row(row).subspan(static_cast<std::size_t>(x), static_cast<std::size_t>(side));
    if (!std::all_of(pixels.begin(), pixels.end(), [&](Seen pixel) { return pixel == what; })) return false;
  }
  return true;
}

}  // namespace

double changed_share(const SurfaceLevel& frame, const SurfaceLevel& model, const Pose& T_model_frame,
                     const SteadyMotion& rows, const NoiseModel& noise) {
  const Image<Seen> seen = compare(frame, model, T_model_frame, rows, noise);
  const int side = std::max(2, static_cast<int>(std::lround(seen.width() / 30.0)));
  Image<std::uint8_t> changed(seen.width(), seen.height(), 0);
  for (int y = 0; y + side <= seen.height(); ++y) {
    for (int x = 0; x + side <= seen.width(); ++x) {
      const Seen what = seen.at(x, y);
      if ((what != Seen::kNearer && what != Seen::kFarther) || !is_full(seen, x, y, side, what)) continue;
      for (int row = y; row < y + side; ++row) std::fill_n(changed.row(row).begin() + x, side, std::uint8_t{1});
    }
  }
  const auto points =
      std::count_if(seen.pixels().begin(), seen.pixels().end(), [](Seen s) { return s != Seen::kNothing; });
  const auto in_patches = std::count(changed.pixels().begin(), changed.pixels().end(), std::uint8_t{1});
  return points > 0 ? static_cast<double>(in_patches) / static_cast<double>(points) : 0;
}

}  // namespace scanknit
