// What is known of a turntable's angles before its pictures are evaluated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquire/frame_source.h"
#include "core/result.h"
#include "fusion/turntable/turntable_prior.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"

namespace scanknit {

/// The angles of ScanJob::angles, turntable.step or turntable.rpm: of the first of these that is given.
class KnownAngles {
 public:
  /// Nothing is known.
  KnownAngles() = default;

  /// Reads ScanJob::angles. Errors: kConfig, with file and line.
  [[nodiscard]] static Result<KnownAngles> read(const ScanJob& job);

  [[nodiscard]] AngleSource source() const;

  /// True when the angle across missing frames is known. False for turntable.step, which counts recorded frames only.
  [[nodiscard]] bool knows_gaps() const { return !file_degrees_.empty() || config_.step_degrees <= 0; }

  /// What gives the angles: `the angle file`, `turntable.step`.
  [[nodiscard]] std::string option() const;

  /// Checks, before any work, that every frame has an angle. Returns a warning when there are more angles than frames.
  /// Errors: kConfig.
  [[nodiscard]] Result<std::optional<std::string>> check(const RecordingInfo& recording) const;

  /// The angle of each frame, up to an offset and with the direction of `seen`; nothing when no angles are known. The
  /// arguments and the result have one entry a frame, in order. Errors: kConfig.
  [[nodiscard]] Result<std::optional<AnglePrior>> of(const std::vector<std::uint64_t>& sequences,
                                                     const std::vector<std::int64_t>& times_ns,
                                                     const TurntableMotion& seen) const;

  /// The text of a warning when the pictures contradict the angles as a whole.
  [[nodiscard]] std::string contradiction(const PriorCheck& check) const;
  /// The text of a warning when the pictures contradict the angles of these frames.
  [[nodiscard]] std::string frames_off(const std::vector<std::uint64_t>& sequences) const;

 private:
  [[nodiscard]] Error no_times() const;
  [[nodiscard]] Error too_few(std::uint64_t frame) const;

  TurntableConfig config_;
  std::string file_, recording_;  ///< for messages
  std::vector<double> file_degrees_;
  std::uint64_t last_frame_ = 0;  ///< the last frame that is selected
};

/// "frame 15", "frames 15 to 37, 40"; `numbers` grow.
[[nodiscard]] std::string frames_text(const std::vector<std::uint64_t>& numbers);

}  // namespace scanknit
