// ReadAhead: reads a recording's next frames while the caller works on those before.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "acquire/frame_source.h"

namespace scanknit {

/// Gives the events of `source`, a recording, in their order. A thread reads and decodes at most kFramesAhead of them
/// before they are asked for.
class ReadAhead final : public FrameSource {
 public:
  static constexpr std::size_t kFramesAhead = 4;

  explicit ReadAhead(std::unique_ptr<FrameSource> source);

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }
  /// Throws what `source` threw.
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;

 private:
  void read(const std::stop_token& stop);
  [[nodiscard]] bool read_one(const std::stop_token& stop);

  std::unique_ptr<FrameSource> source_;
  std::mutex mutex_;
  std::condition_variable_any has_changed_;
  std::deque<FrameEvent> events_;  ///< read, and not asked for yet
  std::exception_ptr failure_;     ///< comes after events_
  bool is_over_ = false;           ///< no event comes after events_
  std::jthread reader_;            ///< last, so that it ends before what it uses
};

/// ReadAhead of `source`, or `source` itself where the program may use one thread only (TBB's max_allowed_parallelism).
[[nodiscard]] std::unique_ptr<FrameSource> read_ahead(std::unique_ptr<FrameSource> source);

}  // namespace scanknit
