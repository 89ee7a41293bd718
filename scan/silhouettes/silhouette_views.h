// The pictures of a job, read and measured.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acquire/pictures/picture_set.h"
#include "fusion/silhouette/visual_hull.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct SilhouettePictures {
  std::vector<SilhouetteView> views;
  std::vector<MaskedPicture> pictures;  ///< of each view
  std::vector<std::string> names;       ///< of each view: its file
  std::vector<std::size_t> numbers;     ///< of each view: its place among all pictures, from 0
  FrameCounts frames;
};

/// Pictures that cannot be used are dropped and counted. A stop request ends the list. Errors: kInput when fewer than
/// two are left, with the reason of the first that was dropped.
[[nodiscard]] Result<SilhouettePictures> read_silhouettes(const PictureSet& set, const ScanConfig& config,
                                                          ScanSession& session);

/// Measures the silhouettes again whose distances do not reach as far as the band in `box`.
void reach_band(const Eigen::AlignedBox3d& box, double truncation_m, SilhouettePictures& read);

/// How well the volume's own outline fills each mask. Warns of a view whose silhouette it does not fill: its pose is
/// wrong, or its mask.
[[nodiscard]] SilhouetteResult agreement_of(const SilhouettePictures& read, const TsdfVolume& volume,
                                            ScanSession& session);

/// The side of a pixel on the thing: the median of the views, metres.
[[nodiscard]] double pixel_size_m(const SilhouettePictures& read, const Eigen::Vector3d& middle);

}  // namespace scanknit
