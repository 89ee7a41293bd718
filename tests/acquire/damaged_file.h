// A recording one of whose files is damaged.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "test_replay_support.h"

namespace scanknit::test {

/// Plays the recording with `file` cut at every byte, and with each of its bytes changed in two ways. Whatever comes
/// of it, there are never more than `most` frames; whole, there are exactly so many.
inline void expect_survives_damage(const std::filesystem::path& recording, const std::filesystem::path& file,
                                   std::size_t most) {
  const auto whole = bytes_of(file);
  const auto frames = [&](const std::vector<std::byte>& bytes) {
    write_bytes(file, bytes);
    const auto source = open_recording(recording, {});
    return source ? play(**source).frames.size() : 0;
  };
  ASSERT_EQ(frames(whole), most);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_LE(frames({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}), most) << "cut at " << size;
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x90}) {
      auto damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      EXPECT_LE(frames(damaged), most) << "byte " << i;
    }
  }
  write_bytes(file, whole);
}

}  // namespace scanknit::test
