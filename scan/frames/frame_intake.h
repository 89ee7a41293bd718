// FrameIntake: the usable frames of a source one by one, with a count of all that happens on the way.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>

#include "acquire/frame_source.h"
#include "core/frame.h"
#include "core/result.h"
#include "scan/frames/sequence_ranges.h"
#include "scan/reconstruction.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

class FrameIntake {
 public:
  struct Options {
    std::stop_token stop = {};  ///< ends the frames
    FrameCounts counted = {};   ///< frames that count already, of a scan whose other frames this source has once more
  };

  /// All references outlive it.
  FrameIntake(FrameSource& source, const AcquireConfig& config, ScanSession& session, Options options);

  /// The next frame that has depth and a pose, or is to be tracked. Nothing when it had to be dropped, which is
  /// counted; when none has come for a twentieth of a second; and when it is over.
  [[nodiscard]] std::optional<Frame> next();

  /// No more frames: the source has ended or failed, was stopped, or finish() was called.
  [[nodiscard]] bool is_over() const { return is_over_; }

  /// Why the last frames could not be used, when there were a few in a row.
  [[nodiscard]] std::optional<DropReason> trouble() const;

  /// A person wants no more frames.
  void finish();

  /// What became of the frame that next() gave.
  void count(const Frame& frame, const Reconstruction::Added& added);

  /// The next frame, usable or not, is left out, counted as dropped for `reason`, one word. It is given to be looked at
  /// if it has pictures.
  std::optional<Frame> pass_over(const char* reason);

  /// All that was fused or lost counts as dropped ("reset").
  void start_over();

  /// The frames were fused again, not all of them, or more; the others count as lost.
  void recount(std::size_t fused);

  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  [[nodiscard]] const RecordingInfo& info() const { return source_.info(); }

  /// The frames that came, usable or not, but for those that were passed over or came before start_over().
  [[nodiscard]] const SequenceRanges& taken() const { return taken_; }
  /// The counts of the others.
  [[nodiscard]] const FrameCounts& left_out() const { return left_out_; }

  /// After the last frame: warns of what was dropped. Errors: the source's own; kInput when not one frame was fused.
  [[nodiscard]] Result<void> conclude();

 private:
  using Event = std::variant<Frame, FrameDropped>;
  [[nodiscard]] std::optional<FrameEvent> wait_for_event();
  [[nodiscard]] std::optional<Event> next_event();
  void count_dropped(const FrameDropped& dropped);
  void leave_out(const std::string& reason);
  void warn_of_dropped();

  FrameSource& source_;
  ScanSession& session_;
  std::stop_token stop_;
  std::size_t expected_;
  FrameCounts counts_;
  std::chrono::steady_clock::duration waited_{};  ///< for the next frame, so far
  std::size_t unusable_ = 0;                      ///< frames in a row
  DropReason last_drop_ = DropReason::kUnreadable;
  bool is_over_ = false, is_finished_ = false;
  std::optional<Error> error_;
  SequenceRanges taken_;
  std::uint64_t newest_ = 0;      ///< sequence number that has come
  std::uint64_t taken_from_ = 0;  ///< since frames were left out
  FrameCounts left_out_;
};

}  // namespace scanknit
