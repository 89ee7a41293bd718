// Bags of ROS whose clouds are the sweeps of a LiDAR.
#pragma once

#include <filesystem>
#include <memory>

#include "acquire/bag/bag_messages.h"
#include "acquire/lidar/sweep_source.h"

namespace scanknit {

/// True for a bag, a file or a folder in which one lies, with clouds that are no pictures, and without depth pictures;
/// or whose clouds acquire.topics.depth names. Reads the bag's index; only where there are clouds, goes over its
/// messages and reads the first ones of each topic of pictures and clouds.
[[nodiscard]] bool fits_bag_sweeps(const std::filesystem::path& path, const AcquireConfig& config);

/// Errors (kInput): no bag; acquire.topics names no such topic; no such clouds; those of opening.
[[nodiscard]] Result<std::unique_ptr<SweepSource>> open_bag_sweeps(const std::filesystem::path& path,
                                                                   const AcquireConfig& config);

/// Of a bag whose files are open; `path` is for messages. Errors (kInput): those of open_bag_sweeps().
[[nodiscard]] Result<std::unique_ptr<SweepSource>> index_bag_sweeps(OpenBag bag, const std::filesystem::path& path,
                                                                    const AcquireConfig& config);

}  // namespace scanknit
