#include "app/only_frames.h"

#include <utility>
#include <variant>

namespace scanknit {

OnlyFrames::OnlyFrames(std::unique_ptr<FrameSource> source, std::set<std::uint64_t> wanted)
    : source_(std::move(source)), wanted_(std::move(wanted)) {}

FrameEvent OnlyFrames::next(std::stop_token stop) {
  while (!wanted_.empty()) {
    FrameEvent event = source_->next(stop);
    const auto* frame = std::get_if<Frame>(&event);
    const auto* dropped = std::get_if<FrameDropped>(&event);
    if (frame == nullptr && dropped == nullptr) return event;
    if (wanted_.erase(frame != nullptr ? frame->sequence : dropped->sequence) > 0) return event;
  }
  return EndOfStream{};
}

}  // namespace scanknit
