// FrameArchive: the frames of a scan, to be read again once they are over.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>

#include "acquire/frame_source.h"
#include "core/result.h"

namespace scanknit {

class FrameArchive {
 public:
  using Open = std::function<Result<std::unique_ptr<FrameSource>>(std::size_t every)>;

  /// Frames that nothing keeps.
  FrameArchive() = default;
  explicit FrameArchive(Open open) : open_(std::move(open)) {}

  /// False: the frames were not kept. open() must not be called.
  [[nodiscard]] bool is_kept() const { return static_cast<bool>(open_); }

  /// Every `every`-th frame, from the first one. Errors: why they cannot be read.
  [[nodiscard]] Result<std::unique_ptr<FrameSource>> open(std::size_t every = 1) const { return open_(every); }

 private:
  Open open_;
};

/// What becomes of reading after a frame.
enum class Reading { kGoOn, kEnough };

/// Calls `visit` with each frame of `source` until that has enough, the source ends, or `stop` is asked for. Dropped
/// frames are passed over. Errors: the source's; those of `visit`.
[[nodiscard]] Result<void> for_each_frame(FrameSource& source, const std::stop_token& stop,
                                          const std::function<Result<Reading>(Frame&)>& visit);

}  // namespace scanknit
