#include "app/scan/frame_intake.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "app/scan/frame_count.h"

namespace scanknit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPatience{50};
constexpr std::size_t kMessagesInReport = 100;
constexpr std::size_t kMessagesOnConsole = 5;

std::string reasons_text(const RunReport::Frames& frames) {
  std::vector<std::string> parts;
  for (const auto& [reason, count] : frames.dropped_by_reason) parts.push_back(fmt::format("{} {}", count, reason));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::uint64_t sequence_of(const std::variant<Frame, FrameDropped>& event) {
  return std::visit([](const auto& any) { return any.sequence; }, event);
}

Error no_usable_frame_error(const RunReport::Frames& frames) {
  std::string why = "there is none, or none that --from, --to and --every ask for";
  if (frames.read > 0) why = fmt::format("all {} were dropped ({})", frames.read, reasons_text(frames));
  const auto without_pose = frames.dropped_by_reason.find(to_string(DropReason::kNoPose));
  if (without_pose != frames.dropped_by_reason.end() && without_pose->second == frames.dropped) {
    why += "; to find the poses from the frames: --poses track; if the scanner did not move: --poses still";
  }
  return {ErrorCode::kInput, "no usable frame: " + why};
}

}  // namespace

FrameIntake::FrameIntake(FrameSource& source, const AcquireConfig& config, std::stop_token stop, Console& console,
                         RunReport& report)
    : source_(source),
      config_(config),
      stop_(std::move(stop)),
      console_(console),
      report_(report),
      expected_(selected_frames(source.info(), config)) {}

std::optional<FrameEvent> FrameIntake::wait_for_event() {
  const auto begin = Clock::now();
  std::optional<FrameEvent> event;
  if (source_.wait(stop_, kPatience)) event = source_.next(stop_);
  waited_ += Clock::now() - begin;
  if (!event) return event;
  const std::chrono::duration<double, std::milli> spent = std::exchange(waited_, {});
  report_.stages["acquire"].samples_ms.push_back(spent.count());
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
  ++report_.frames.read;
  console_.progress("fusing", report_.frames.read, expected_);
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
  if (dropped != nullptr && sequence < taken_from_) {  // a scanner's pictures that gave way are told of late
    leave_out(to_string(dropped->reason));
    return std::nullopt;
  }
  taken_.add(sequence);
  if (dropped != nullptr) {
    note_dropped(*dropped);
    return std::nullopt;
  }
  Frame& frame = std::get<Frame>(*event);
  if (source_.info().poses == PoseMode::kRecording && !frame.T_world_camera) {
    note_dropped({frame.sequence, DropReason::kNoPose, {ErrorCode::kInput, "the recording has no pose for it"}});
    return std::nullopt;
  }
  unusable_ = 0;
  return std::move(frame);
}

std::optional<DropReason> FrameIntake::trouble() const {
  constexpr std::size_t kFew = 3;  // single frames may well be missing
  return unusable_ >= kFew ? std::optional(last_drop_) : std::nullopt;
}

void FrameIntake::finish() {
  is_over_ = true;
  is_finished_ = true;
}

void FrameIntake::note_fused(const Frame& frame, const Pose& T_world_camera, bool is_budget_reached) {
  ++report_.frames.fused;
  const double stamp =
      frame.has_clock ? static_cast<double>(frame.timestamp_ns) * 1e-9 : static_cast<double>(frame.sequence);
  trajectory_.push_back({stamp, T_world_camera});
  fused_sequences_.push_back(frame.sequence);
  if (is_budget_reached && !report_.volume.is_budget_reached) {
    report_.volume.is_budget_reached = true;
    console_.warn(fmt::format(
        "frame {}: the volume has reached fusion.memory_budget and grows no further; what it holds is still "
        "refined",
        frame.sequence));
  }
}

void FrameIntake::note_refused(const Frame& frame, const Error& error) {
  note_dropped({frame.sequence, DropReason::kBadPose, error});
}

std::optional<Frame> FrameIntake::pass_over(const char* reason) {
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
  for (RunReport::Frames* frames : {&report_.frames, &left_out_}) {
    ++frames->dropped;
    ++frames->dropped_by_reason[reason];
  }
}

void FrameIntake::start_over() {
  RunReport::Frames& frames = report_.frames;
  const std::size_t forgotten = frames.fused + frames.lost;
  frames.dropped += forgotten;
  if (forgotten > 0) frames.dropped_by_reason["reset"] += forgotten;
  frames.fused = 0;
  frames.lost = 0;
  report_.tracking.reset();
  report_.volume.is_budget_reached = false;
  trajectory_.clear();
  fused_sequences_.clear();
  taken_.clear();
  taken_from_ = newest_ + 1;
  left_out_ = frames;
}

void FrameIntake::replace_trajectory(std::vector<StampedPose> trajectory, std::vector<std::uint64_t> sequences) {
  RunReport::Frames& frames = report_.frames;
  frames.fused = trajectory.size();
  frames.lost = frames.read - frames.dropped - frames.fused;
  trajectory_ = std::move(trajectory);
  fused_sequences_ = std::move(sequences);
}

void FrameIntake::correct(const std::vector<Pose>& T_world_cameras) {
  for (std::size_t i = 0; i < trajectory_.size(); ++i) trajectory_[i].T_world_camera = T_world_cameras[i];
}

void FrameIntake::note_dropped(const FrameDropped& dropped) {
  RunReport::Frames& frames = report_.frames;
  ++frames.dropped;
  ++frames.dropped_by_reason[to_string(dropped.reason)];
  if (dropped.reason != DropReason::kQueue) ++unusable_;
  last_drop_ = dropped.reason;
  std::string message = fmt::format("frame {}: {}", dropped.sequence, dropped.error.text());
  console_.debug(message);
  if (frames.drop_messages.size() < kMessagesInReport) frames.drop_messages.push_back(std::move(message));
}

void FrameIntake::say_dropped() {
  const RunReport::Frames& frames = report_.frames;
  if (frames.dropped == 0) return;
  console_.warn(fmt::format("{} of {} frames dropped: {}", frames.dropped, frames.read, reasons_text(frames)));
  for (std::size_t i = 0; i < std::min(frames.drop_messages.size(), kMessagesOnConsole); ++i) {
    console_.warn("  " + frames.drop_messages[i]);
  }
  if (frames.dropped > kMessagesOnConsole) console_.warn("  ... the others are in the report");
}

Result<void> FrameIntake::result() {
  say_dropped();
  const RunReport::Frames& frames = report_.frames;
  if (error_ && frames.fused == 0) return *error_;
  if (error_) console_.warn(fmt::format("the recording ends early: {}", error_->text()));
  if (frames.fused > 0) {
    if (stop_.stop_requested()) {
      console_.warn(fmt::format("interrupted: meshing the {} frames fused so far", frames.fused));
    }
    return {};
  }
  if (stop_.stop_requested()) return Error{ErrorCode::kInput, "interrupted before the first frame was fused"};
  if (is_finished_) return Error{ErrorCode::kInput, "finished before the first frame was fused"};
  return no_usable_frame_error(frames);
}

}  // namespace scanknit
