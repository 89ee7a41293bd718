// FrameIntake: gives the usable frames of a source one by one, and counts all frames.
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
  static constexpr std::size_t kMostDropMessages = 100;  ///< in FrameCounts::drop_messages

  struct Options {
    std::stop_token stop = {};  ///< ends the frames
    FrameCounts counted = {};   ///< counts to start with: frames of the same scan that this source does not have
    std::string name = {};      ///< of the recording, where a scan has several: warnings begin with it
  };

  /// All references outlive it.
  FrameIntake(FrameSource& source, const AcquireConfig& config, ScanSession& session, Options options);

  /// The next frame that has depth, and a pose unless poses are tracked. Nothing when the frame had to be dropped (it
  /// is counted), when none has come for a twentieth of a second, and when is_over().
  [[nodiscard]] std::optional<Frame> next();

  /// True when no more frames come: the source has ended, failed or been stopped, or finish() was called.
  [[nodiscard]] bool is_over() const { return is_over_; }

  /// Why the last frames could not be used; nothing unless there were a few in a row.
  [[nodiscard]] std::optional<DropReason> trouble() const;

  /// Ends the frames, because the user asked for it.
  void finish();

  /// Counts the frame that next() returned as fused, lost or dropped, according to `added`.
  void count(const Frame& frame, const Reconstruction::Added& added);

  /// Skips the next frame, usable or not, and counts it as dropped for `reason`, one word. Returns it for display if it
  /// has pictures.
  std::optional<Frame> skip_frame(const char* reason);

  /// Counts all frames that were fused or lost as dropped ("reset").
  void start_over();

  /// Sets the number of fused frames after they were fused again; the others count as lost.
  void recount(std::size_t fused);

  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  [[nodiscard]] const RecordingInfo& info() const { return source_.info(); }

  /// The frames that came, usable or not, except those that were skipped by skip_frame() or came before start_over().
  [[nodiscard]] const SequenceRanges& taken() const { return taken_; }
  /// The counts of frames that are not in taken().
  [[nodiscard]] const FrameCounts& left_out() const { return left_out_; }

  /// To be called after the last frame: warns of dropped frames. Errors: those of the source; kInput when no frame was
  /// fused.
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
  std::chrono::steady_clock::duration waited_{};  ///< time spent waiting for the next frame so far
  std::size_t unusable_ = 0;                      ///< number of unusable frames in a row
  DropReason last_drop_ = DropReason::kUnreadable;
  bool is_over_ = false, is_finished_ = false;
  std::optional<Error> error_;
  SequenceRanges taken_;
  std::uint64_t newest_ = 0;      ///< highest sequence number that has come
  std::uint64_t taken_from_ = 0;  ///< frames before this sequence number are left out
  FrameCounts left_out_;
  std::string begin_of_warnings_;  ///< empty, or "NAME: "
};

}  // namespace scanknit
