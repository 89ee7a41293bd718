#include "scan/frames/frame_intake.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "scan/frames/frame_count.h"

namespace scanknit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPatience{50};
constexpr std::size_t kMessagesInWarning = 5;

std::string reasons_text(const FrameCounts& frames) {
  std::vector<std::string> parts;
  for (const auto& [reason, count] : frames.dropped_by_reason) parts.push_back(fmt::format("{} {}", count, reason));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::uint64_t sequence_of(const std::variant<Frame, FrameDropped>& event) {
  return std::visit([](const auto& any) { return any.sequence; }, event);
}

Error no_usable_frame_error(const FrameCounts& frames) {
  std::string why = "the recording holds no frame, or none in the range that was chosen";
  if (frames.read > 0) why = fmt::format("all {} were dropped ({})", frames.read, reasons_text(frames));
  const auto without_pose = frames.dropped_by_reason.find(to_string(DropReason::kNoPose));
  if (without_pose != frames.dropped_by_reason.end() && without_pose->second == frames.dropped) {
    why += "; acquire.poses=track finds the poses from the frames; acquire.poses=still: the scanner did not move";
  }
  return {ErrorCode::kInput, "no usable frame: " + why};
}

}  // namespace

FrameIntake::FrameIntake(FrameSource& source, const AcquireConfig& config, ScanSession& session, Options options)
    : source_(source),
      session_(session),
      stop_(std::move(options.stop)),
      expected_(selected_frames(source.info(), config)),
      counts_(std::move(options.counted)),
      left_out_(counts_),
      begin_of_warnings_(options.name.empty() ? "" : options.name + ": ") {}

std::optional<FrameEvent> FrameIntake::wait_for_event() {
  const PeakMemoryWatch memory = session_.watch_memory("acquire");
  const auto begin = Clock::now();
  std::optional<FrameEvent> event;
  if (source_.wait(stop_, kPatience)) event = source_.next(stop_);
  waited_ += Clock::now() - begin;
  if (!event) return event;
  const std::chrono::duration<double, std::milli> spent = std::exchange(waited_, {});
  session_.note_time("acquire", spent.count());
  return event;
}

std::optional<FrameIntake::Event> FrameIntake::next_event() {
  if (is_over_) return std::nullopt;
  auto event = wait_for_event();
  if (!event) return std::nullopt;
  if (auto* error = std::get_if<Error>(&*event)) error_ = std::move(*error);
  if (error_ || std::holds_alternative<EndOfStream>(*event)) {
    is_over_ = true;
    return std::nullopt;
  }
  ++counts_.read;
  session_.progress("fusing", counts_.read, expected_);
  Event taken = std::holds_alternative<Frame>(*event) ? Event(std::get<Frame>(std::move(*event)))
                                                      : Event(std::get<FrameDropped>(std::move(*event)));
  newest_ = std::max(newest_, sequence_of(taken));
  return taken;
}

std::optional<Frame> FrameIntake::next() {
  auto event = next_event();
  if (!event) return std::nullopt;
  const auto* dropped = std::get_if<FrameDropped>(&*event);
  const std::uint64_t sequence = sequence_of(*event);
  if (dropped != nullptr && sequence < taken_from_) {  // discarded pictures of a scanner are reported late
    leave_out(to_string(dropped->reason));
    return std::nullopt;
  }
  taken_.add(sequence);
  if (dropped != nullptr) {
    count_dropped(*dropped);
    return std::nullopt;
  }
  Frame& frame = std::get<Frame>(*event);
  if (source_.info().poses == PoseMode::kRecording && !frame.T_world_camera) {
    count_dropped({frame.sequence, DropReason::kNoPose, {ErrorCode::kInput, "the recording has no pose for it"}});
    return std::nullopt;
  }
  unusable_ = 0;
  return std::move(frame);
}

std::optional<DropReason> FrameIntake::trouble() const {
  constexpr std::size_t kFew = 3;  // one or two missing frames are normal
  return unusable_ >= kFew ? std::optional(last_drop_) : std::nullopt;
}

void FrameIntake::finish() {
  is_over_ = true;
  is_finished_ = true;
}

void FrameIntake::count(const Frame& frame, const Reconstruction::Added& added) {
  if (added.T_world_camera) {
    ++counts_.fused;
  } else if (added.refused) {
    count_dropped({frame.sequence, DropReason::kBadPose, *added.refused});
  } else if (is_tracked(source_.info().poses)) {
    ++counts_.lost;
  }
}

std::optional<Frame> FrameIntake::skip_frame(const char* reason) {
  auto event = next_event();
  if (!event) return std::nullopt;
  leave_out(reason);
  taken_.cut();
  taken_from_ = newest_ + 1;
  unusable_ = 0;
  auto* frame = std::get_if<Frame>(&*event);
  return frame != nullptr ? std::optional(std::move(*frame)) : std::nullopt;
}

void FrameIntake::leave_out(const std::string& reason) {
  ++left_out_.read;
  for (FrameCounts* frames : {&counts_, &left_out_}) {
    ++frames->dropped;
    ++frames->dropped_by_reason[reason];
  }
}

void FrameIntake::start_over() {
  const std::size_t forgotten = counts_.fused + counts_.lost;
  counts_.dropped += forgotten;
  if (forgotten > 0) counts_.dropped_by_reason["reset"] += forgotten;
  counts_.fused = 0;
  counts_.lost = 0;
  taken_.clear();
  taken_from_ = newest_ + 1;
  left_out_ = counts_;
}

void FrameIntake::recount(std::size_t fused) {
  counts_.fused = fused;
  counts_.lost = counts_.read - counts_.dropped - fused;
}

void FrameIntake::count_dropped(const FrameDropped& dropped) {
  ++counts_.dropped;
  ++counts_.dropped_by_reason[to_string(dropped.reason)];
  if (dropped.reason != DropReason::kQueue) ++unusable_;
  last_drop_ = dropped.reason;
  std::string message = fmt::format("frame {}: {}", dropped.sequence, dropped.error.text());
  session_.debug(message);
  if (counts_.drop_messages.size() < kMostDropMessages) counts_.drop_messages.push_back(std::move(message));
}

/// One warning, with a line for each of the first messages.
void FrameIntake::warn_of_dropped() {
  if (counts_.dropped == 0) return;
  std::string text = fmt::format("{}{} of {} frames dropped: {}", begin_of_warnings_, counts_.dropped, counts_.read,
                                 reasons_text(counts_));
  for (std::size_t i = 0; i < std::min(counts_.drop_messages.size(), kMessagesInWarning); ++i) {
    text += "\n  " + counts_.drop_messages[i];
  }
  if (counts_.dropped > kMessagesInWarning) {
    text += fmt::format("\n  ... and {} more", counts_.dropped - kMessagesInWarning);
  }
  session_.warn(WarningCode::kFramesDropped, std::move(text));
}

Result<void> FrameIntake::conclude() {
  warn_of_dropped();
  if (error_ && counts_.fused == 0) return *error_;
  if (error_) {
    session_.warn(WarningCode::kRecordingEndsEarly,
                  fmt::format("{}the recording ends early: {}", begin_of_warnings_, error_->text()));
  }
  if (counts_.fused > 0) {
    if (stop_.stop_requested()) {
      session_.warn(WarningCode::kStoppedEarly, fmt::format("{}interrupted: meshing the {} frames fused so far",
                                                            begin_of_warnings_, counts_.fused));
    }
    return {};
  }
  if (stop_.stop_requested()) return Error{ErrorCode::kInput, "interrupted before the first frame was fused"};
  if (is_finished_) return Error{ErrorCode::kInput, "finished before the first frame was fused"};
  return no_usable_frame_error(counts_);
}

}  // namespace scanknit
