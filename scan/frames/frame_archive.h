// FrameArchive: reads the frames of a scan again, after the scan.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <stop_token>
#include <utility>

#include "acquire/frame_source.h"
#include "core/result.h"

namespace scanknit {

class FrameArchive {
 public:
  using Open = std::function<Result<std::unique_ptr<FrameSource>>(std::size_t every)>;

  /// An archive of frames that were not kept.
  FrameArchive() = default;
  /// `most_frames`: open() yields no more.
  explicit FrameArchive(Open open, std::size_t most_frames = std::numeric_limits<std::size_t>::max())
      : open_(std::move(open)), most_frames_(most_frames) {}

  /// False: the frames were not kept. open() must not be called.
  [[nodiscard]] bool is_kept() const { return static_cast<bool>(open_); }

  [[nodiscard]] std::size_t most_frames() const { return most_frames_; }

  /// Opens every `every`-th frame, from the first one. Errors: why they cannot be read.
  [[nodiscard]] Result<std::unique_ptr<FrameSource>> open(std::size_t every = 1) const { return open_(every); }

 private:
  Open open_;
  std::size_t most_frames_ = 0;
};

/// Whether reading goes on after a frame.
enum class Reading { kContinue, kStop };

/// Calls `visit` with each frame of `source` until `visit` returns kStop, the source ends, or `stop` is requested.
/// Skips dropped frames. Errors: those of the source and of `visit`.
[[nodiscard]] Result<void> for_each_frame(FrameSource& source, const std::stop_token& stop,
                                          const std::function<Result<Reading>(Frame&)>& visit);

}  // namespace scanknit
