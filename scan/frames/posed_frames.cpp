#include "scan/frames/posed_frames.h"

#include <utility>
#include <variant>

namespace scanknit {

PosedFrames::PosedFrames(std::unique_ptr<FrameSource> source, TrajectoryFile poses, std::size_t from, std::size_t every)
    : source_(std::move(source)), poses_(std::move(poses)), info_(source_->info()), place_(from), every_(every) {
  info_.poses = PoseMode::kRecording;
}

FrameEvent PosedFrames::next(std::stop_token stop) {
  FrameEvent event = source_->next(stop);
  if (!std::holds_alternative<Frame>(event) && !std::holds_alternative<FrameDropped>(event)) return event;
  const std::size_t place = place_;
  place_ += every_;
  auto* frame = std::get_if<Frame>(&event);
  if (frame == nullptr) return event;
  const auto pose = poses_.pose_of(*frame, place);
  if (!pose) {
    return FrameDropped{
        frame->sequence, DropReason::kNoPose, {ErrorCode::kInput, "the trajectory has no pose of this frame"}};
  }
  if (!*pose) return FrameDropped{frame->sequence, DropReason::kBadPose, pose->error()};
  frame->T_world_camera = **pose;
  return event;
}

}  // namespace scanknit
