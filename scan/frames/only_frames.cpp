#include "scan/frames/only_frames.h"

#include <utility>
#include <variant>

namespace scanknit {

OnlyFrames::OnlyFrames(std::unique_ptr<FrameSource> source, SequenceRanges wanted)
    : source_(std::move(source)), skipping_(dynamic_cast<SkippingSource*>(source_.get())), wanted_(std::move(wanted)) {}

FrameEvent OnlyFrames::next(std::stop_token stop) {
  while (true) {
    if (skipping_ != nullptr) {
      skipping_->skip_until(
          [&](std::uint64_t sequence) { return wanted_.contains(sequence) || wanted_.end_before(sequence); });
    }
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
