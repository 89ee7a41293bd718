// The data packets of Velodyne's LiDARs: VLP-16, Puck LITE, Puck Hi-Res, VLP-32C, HDL-32E.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "acquire/lidar/lidar_packets.h"
#include "core/result.h"

namespace scanknit {

/// A reader for the sensor that sent this packet; nothing where no Velodyne did. Errors (kInput, without `where`): a
/// model that is not read, and why.
[[nodiscard]] std::optional<Result<std::unique_ptr<LidarPackets>>> velodyne_of(std::span<const std::byte> packet);

}  // namespace scanknit
