// OnlyFrames: some frames of a source.
#pragma once

#include <memory>

#include "acquire/frame_source.h"
#include "acquire/replay/skipping_source.h"
#include "scan/frames/sequence_ranges.h"

namespace scanknit {

/// The frames of `source` whose sequence numbers are selected; ends after the last of them. The others are not read
/// where the source can pass over them.
class OnlyFrames final : public FrameSource {
 public:
  OnlyFrames(std::unique_ptr<FrameSource> source, SequenceRanges wanted);

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;

 private:
  std::unique_ptr<FrameSource> source_;
  SkippingSource* skipping_;  ///< source_; null: it cannot
  SequenceRanges wanted_;
};

}  // namespace scanknit
