#include "scan/frames/only_frames.h"

#include <utility>
#include <variant>

namespace scanknit {

OnlyFrames::OnlyFrames(std::unique_ptr<FrameSource> source, SequenceRanges wanted)
    : source_(std::move(source)), wanted_(std::move(wanted)) {}

FrameEvent OnlyFrames::next(std::stop_token stop) {
  while (true) {
    FrameEvent event = source_->next(stop);
    const auto* frame = std::get_if<Frame>(&event);
    const auto* dropped = std::get_if<FrameDropped>(&event);
    if (frame == nullptr && dropped == nullptr) return event;
    const std::uint64_t sequence = frame != nullptr ? frame->sequence : dropped->sequence;
    if (wanted_.end_before(sequence)) return EndOfStream{};
    if (wanted_.contains(sequence)) return event;
  }
}

}  // namespace scanknit
