// Captures of the packets of a LiDAR (.pcap, .pcapng), with a trajectory beside them.
#pragma once

#include <filesystem>
#include <memory>

#include "acquire/lidar/sweep_source.h"
#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// Reads packets of Velodyne (velodyne_packets.h), and of Ouster with the sensor's metadata in a .json beside the
/// capture. The first LiDAR of the capture is read. The whole capture is read once to find where sweeps begin. The
/// world is that of the trajectory, z up. Errors: those of open_sweeps().
[[nodiscard]] Result<std::unique_ptr<SweepSource>> open_pcap_sweeps(const std::filesystem::path& path,
                                                                    const Limits& limits);

/// The same of a capture that is open; `path` is where its other files are looked for.
[[nodiscard]] Result<std::unique_ptr<SweepSource>> open_pcap_sweeps(std::unique_ptr<RandomAccess> file,
                                                                    const std::filesystem::path& path,
                                                                    const Limits& limits);

}  // namespace scanknit
