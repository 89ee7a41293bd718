// PosedFrames: a source's frames at the poses of a file.
#pragma once

#include <cstddef>
#include <memory>

#include "acquire/frame_source.h"
#include "acquire/parse/trajectory_file.h"

namespace scanknit {

/// Whatever poses the recording has, its frames get those of the file; a frame without one is dropped (kNoPose).
class PosedFrames final : public FrameSource {
 public:
  /// `source` was opened with acquire.poses = still, from frame `from` on, every `every`-th.
  PosedFrames(std::unique_ptr<FrameSource> source, TrajectoryFile poses, std::size_t from, std::size_t every);

  /// `poses` is kRecording.
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;

 private:
  std::unique_ptr<FrameSource> source_;
  TrajectoryFile poses_;
  RecordingInfo info_;
  std::size_t place_, every_;  ///< of the next frame, in the recording
};

}  // namespace scanknit
