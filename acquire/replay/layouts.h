// The layouts that are recognised, and their indexers. One .cpp each.
#pragma once

#include "acquire/acquire_config.h"
#include "acquire/replay/folder.h"
#include "acquire/replay/recording.h"
#include "core/result.h"

namespace scanknit {

// fits_*: true if the folder has this layout. index_*: lists the frames of a folder that fits. Errors (kInput) name the
// file. Neither opens a picture.

[[nodiscard]] bool fits_seven_scenes(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_seven_scenes(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_tum(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_tum(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_nerfstudio(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_nerfstudio(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_open3d(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_open3d(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_phone_lidar(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_phone_lidar(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_stray_scanner(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_stray_scanner(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_arkitscenes(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_arkitscenes(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_polycam(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_polycam(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_replica(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_replica(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_bop(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_bop(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_fakenect(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_fakenect(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_pcd(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_pcd(const Folder& folder, const AcquireConfig& config);

/// A bag of ROS 2 in several files.
[[nodiscard]] bool fits_split_bag(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_split_bag(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_pclzf(const Folder& folder, const Limits& limits);
[[nodiscard]] Result<Recording> index_pclzf(const Folder& folder, const AcquireConfig& config);

/// Whether a folder has pairs of pictures (config.geometry: kStereo). index_stereo() opens the first of them, and some
/// more to see that they fit each other. Errors (kInput, kConfig, kInternal): its files are missing or do not fit, a
/// setting that stereo pairs do not allow, OpenCV's module is missing.
[[nodiscard]] bool has_stereo_pairs(const std::filesystem::path& path, const Limits& limits);
[[nodiscard]] Result<Recording> index_stereo(const std::filesystem::path& path, const AcquireConfig& config);

}  // namespace scanknit
