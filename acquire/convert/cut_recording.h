// CutRecording: writes frames with known poses, from whose depth something was cut, as a recording for `align` and
// other programs.
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
  /// Checks that `folder` is new or empty and can be made; leaves nothing behind. Errors: kOutput.
  [[nodiscard]] static Result<void> check(const std::filesystem::path& folder);

  /// `folder` is new or empty. Errors: kOutput.
  [[nodiscard]] static Result<CutRecording> create(const std::filesystem::path& folder);
  CutRecording(CutRecording&&) noexcept;
  /// Removes a recording that was not finished.
  ~CutRecording();

  /// The frame has a pose. Errors: kOutput.
  [[nodiscard]] Result<void> write(const Frame& frame);
  /// To be called after the last frame, when at least one was written. Errors: kOutput.
  [[nodiscard]] Result<void> finish();

 private:
  CutRecording(std::unique_ptr<RecordingTarget> target, std::filesystem::path folder);
  std::unique_ptr<RecordingTarget> target_;  ///< null when moved from
  std::filesystem::path folder_;
  std::size_t written_ = 0;
  bool is_finished_ = false;
};

}  // namespace scanknit
