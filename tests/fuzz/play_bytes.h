// A recording in memory, played to its end within small limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "acquire/raw/raw_recording.h"

namespace scanknit {

/// `index`: index_mcap, index_oni, index_sens, index_record3d, index_realsense_bag, or index_ros2 of a file.
template <typename Index>
void play_bytes(const std::uint8_t* bytes, std::size_t size, Index index) {
  AcquireConfig config;
  config.limits.max_image_bytes = 1u << 20;
  config.limits.max_image_pixels = 1 << 16;
  config.limits.max_frames = 1000;
  const std::span<const std::uint8_t> input(bytes, size);
  const auto recording = index(std::make_unique<MemoryAccess>(std::as_bytes(input)), "fuzz", config);
  if (!recording) return;
  const DecodeSettings settings{.depth_scale = 1000, .min_confidence = 0, .limits = config.limits};
  for (const FrameEntry& entry : recording->entries) (void)recording->decode(entry, settings);
}

}  // namespace scanknit
