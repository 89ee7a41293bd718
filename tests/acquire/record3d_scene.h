// The depth in the recording and the streams that the reference encoder of LZFSE made (tests/fuzz/corpus).
#pragma once

#include <vector>

#include "acquire/mcap/byte_appender.h"
#include "core/image.h"

namespace scanknit::test {

inline constexpr int kSceneWidth = 48, kSceneHeight = 32;

/// Metres; 0 where there is none.
[[nodiscard]] inline float scene_depth_m(int first_mm, int x, int y) {
  return (x + y) % 11 == 0 ? 0.0F : static_cast<float>((first_mm + 2 * x + 3 * y + x * y % 7) / 1000.0);
}

[[nodiscard]] inline std::vector<std::byte> scene_depth_bytes(int first_mm) {
  std::vector<std::byte> bytes;
  ByteAppender out(bytes);
  for (int y = 0; y < kSceneHeight; ++y) {
    for (int x = 0; x < kSceneWidth; ++x) out.little_endian(scene_depth_m(first_mm, x, y));
  }
  return bytes;
}

}  // namespace scanknit::test
