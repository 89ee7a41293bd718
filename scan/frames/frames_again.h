// FramesAgain: reads chosen frames of an archive, forward or backwards.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>

#include "scan/frames/frame_archive.h"

namespace scanknit {

/// A recording can be read forward only. Goes on from where it is, and opens the archive again only for frames that lie
/// before that: choose frames in the order of the scan where possible.
class FramesAgain {
 public:
  using Visit = std::function<Result<Reading>(Frame& frame)>;

  /// `archive` is kept, and outlives it.
  FramesAgain(const FrameArchive& archive, std::stop_token stop) : archive_(archive), stop_(std::move(stop)) {}

  /// Calls `visit` with the frames that have these sequence numbers, which ascend, until `visit` returns kStop or
  /// `stop` is requested. Frames that are not there any more are left out. Errors: those of the archive, its frames,
  /// `visit`.
  [[nodiscard]] Result<void> for_each_of(std::span<const std::uint64_t> sequences, const Visit& visit);

  /// The same, the last frame first. Keeps at most kMostKept frames in memory.
  [[nodiscard]] Result<void> for_each_backwards(std::span<const std::uint64_t> sequences, const Visit& visit);

 private:
  static constexpr std::size_t kMostKept = 32;  // 2 MB each at 640 x 480

  const FrameArchive& archive_;
  std::stop_token stop_;
  std::unique_ptr<FrameSource> source_;
  std::optional<std::uint64_t> last_read_;
};

}  // namespace scanknit
