// CutRecording: frames with known poses, some of their depth cut away, as a recording for other programs and `align`.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "core/frame.h"
#include "core/result.h"

namespace scanknit {

class RecordingTarget;

/// Open3D's layout: depth/ in tenths of a millimetre, color/, camera_intrinsic.json, trajectory.log.
class CutRecording {
 public:
  /// Whether `folder` is new or empty and can be made; leaves nothing behind. Errors: kOutput.
  [[nodiscard]] static Result<void> check(const std::filesystem::path& folder);

  /// A folder that is new or empty. Errors: kOutput.
  [[nodiscard]] static Result<CutRecording> create(const std::filesystem::path& folder);
  CutRecording(CutRecording&&) noexcept;
  /// What was not finished is removed.
  ~CutRecording();

  /// The frame has a pose. Errors: kOutput.
  [[nodiscard]] Result<void> write(const Frame& frame);
  /// After the last frame; at least one was written. Errors: kOutput.
  [[nodiscard]] Result<void> finish();

 private:
  CutRecording(std::unique_ptr<RecordingTarget> target, std::filesystem::path folder);
  std::unique_ptr<RecordingTarget> target_;  ///< nothing when moved from
  std::filesystem::path folder_;
  std::size_t written_ = 0;
  bool is_finished_ = false;
};

}  // namespace scanknit
