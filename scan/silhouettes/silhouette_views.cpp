#include "scan/silhouettes/silhouette_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/median.h"
#include "scan/checks/memory_share.h"

namespace scanknit {
namespace {

constexpr double kFirstReach_px = 16;  // enough to find the box; the band may ask for more

/// So many pixels of a picture that all of them take half of the volume's memory budget, with what is kept of each
/// pixel.
std::size_t most_pixels(const PictureSet& set, const ScanConfig& config) {
  constexpr std::size_t kBytes = 8;  // colour, mask, distance, tiles
  const std::size_t bytes = (volume_budget_mib(config.fusion.memory_budget_mib) << 20) / 2;
  return std::max<std::size_t>(1, bytes / kBytes / std::max<std::size_t>(1, set.pictures.size()));
}

void drop(const Error& error, FrameCounts& frames) {
  constexpr std::size_t kMostMessages = 100;
  ++frames.dropped;
  ++frames.dropped_by_reason[to_string(DropReason::kUnreadable)];
  if (frames.drop_messages.size() < kMostMessages) frames.drop_messages.push_back(error.text());
}

}  // namespace

Result<SilhouettePictures> read_silhouettes(const PictureSet& set, const ScanConfig& config, ScanSession& session) {
  const auto empty = read_empty_picture(config.acquire);
  if (!empty) return empty.error();
  SilhouettePictures read;
  std::optional<Error> first_error;
  const std::size_t pixels = most_pixels(set, config);
  for (std::size_t i = 0; i < set.pictures.size() && !session.is_stopped(); ++i) {
    session.progress("reading", i + 1, set.pictures.size());
    ++read.frames.read;
    const PlacedPicture& posed = set.pictures[i];
    auto picture = session.timed("acquire", [&] { return read_masked_picture(posed, *empty, config.acquire, pixels); });
    if (!picture) {
      drop(picture.error(), read.frames);
      if (!first_error) first_error = picture.error();
      continue;
    }
    session.timed("filter", [&] {
      read.views.push_back({picture->camera, posed.T_world_camera, Silhouette(picture->mask, kFirstReach_px)});
    });
    read.pictures.push_back(*std::move(picture));
    read.names.push_back(posed.picture.filename().string());
    read.numbers.push_back(i);
  }
  if (read.views.size() < 2 && first_error) return *first_error;
  if (read.views.size() < 2) return Error{ErrorCode::kTooLittle, "a hull needs at least two pictures"};
  return read;
}

void reach_band(const Eigen::AlignedBox3d& box, double truncation_m, SilhouettePictures& read) {
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    SilhouetteView& view = read.views[i];
    const Pose T_camera_world = view.T_world_camera.inverse();
    double nearest = (T_camera_world * box.center()).z();
    for (int corner = 0; corner < 8; ++corner) {
      const auto at = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
      nearest = std::min(nearest, (T_camera_world * box.corner(at)).z());
    }
    const double band_px =
        nearest > 0 ? truncation_m * focal_length(view.camera) / nearest : Silhouette::kLongestReach_px;
    const double wanted = std::min(std::ceil(band_px) + 2, Silhouette::kLongestReach_px);
    if (wanted > view.silhouette.reach_px()) view.silhouette = Silhouette(read.pictures[i].mask, wanted);
  }
}

SilhouetteResult agreement_of(const SilhouettePictures& read, const TsdfVolume& volume, ScanSession& session) {
  SilhouetteResult silhouettes{.pictures = read.views.size()};
  double sum = 0;
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const SilhouetteFit fit = compare_silhouette(read.views[i], volume);
    sum += fit.agreement;
    if (fit.overlap >= silhouettes.worst_overlap) continue;
    silhouettes.worst_overlap = fit.overlap;
    silhouettes.worst_picture = read.names[i];
  }
  silhouettes.agreement = sum / static_cast<double>(read.views.size());
  constexpr double kPoor = 0.9;
  if (silhouettes.worst_overlap < kPoor) {
    session.warn(WarningCode::kSilhouettes,
                 fmt::format("{}: mesh and mask overlap by {:.0f} % only. Its pose or its mask is wrong, or those of "
                             "others cut the thing off",
                             silhouettes.worst_picture, 100 * silhouettes.worst_overlap));
  }
  return silhouettes;
}

double pixel_size_m(const SilhouettePictures& read, const Eigen::Vector3d& middle) {
  std::vector<double> sizes;
  for (const SilhouetteView& view : read.views) {
    const double z = (view.T_world_camera.inverse() * middle).z();
    if (z > 0) sizes.push_back(z / focal_length(view.camera));
  }
  return median(std::move(sizes));
}

}  // namespace scanknit
