// OnlyFrames: some frames of a source.
#pragma once

#include <cstdint>
#include <memory>
#include <set>

#include "acquire/frame_source.h"

namespace scanknit {

/// The frames of `source` whose sequence numbers are wanted; it ends after the last of them.
class OnlyFrames final : public FrameSource {
 public:
  OnlyFrames(std::unique_ptr<FrameSource> source, std::set<std::uint64_t> wanted);

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;

 private:
  std::unique_ptr<FrameSource> source_;
  std::set<std::uint64_t> wanted_;
};

}  // namespace scanknit
