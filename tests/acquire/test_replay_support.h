// Tiny recordings that tests write for themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/frame_source.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/places.h"

namespace scanknit::test {

inline constexpr int kWidth = 8;
inline constexpr int kHeight = 6;
inline constexpr const char* kIdentity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
inline constexpr const char* kMatrix = "100 0 3.5\n0 100 2.5\n0 0 1\n";

/// Missing folders are made on the way.
void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes);
[[nodiscard]] std::vector<std::byte> bytes_of(const std::filesystem::path& path);

/// A depth PNG of one value.
void write_depth(const std::filesystem::path& path, std::uint16_t raw, int width = kWidth, int height = kHeight);
/// A picture of one colour, PNG or JPEG by its extension.
void write_colour(const std::filesystem::path& path, Rgb8 colour, int width = kWidth, int height = kHeight);
void write_grey8(const std::filesystem::path& path, std::uint8_t value, int width = kWidth, int height = kHeight);

/// `count` frames of 1 m depth at the identity, numbered from 0.
void write_seven_scenes(const std::filesystem::path& folder, int count);
[[nodiscard]] std::string seven_scenes_name(int number, std::string_view what);

/// What a recording yields until its end.
struct Played {
  std::vector<Frame> frames;
  std::vector<FrameDropped> dropped;
  std::vector<Error> errors;

  /// The words of the reasons, in order.
  [[nodiscard]] std::vector<std::string> reasons() const;
};
[[nodiscard]] Played play(FrameSource& source);

/// Opens and plays; the test fails when it cannot be opened.
[[nodiscard]] Played play(const std::filesystem::path& path, const AcquireConfig& config = {});

/// The message of open_recording's error, or "" when it opens.
[[nodiscard]] std::string open_error(const std::filesystem::path& path, const AcquireConfig& config = {});

}  // namespace scanknit::test
