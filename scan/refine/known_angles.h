// What is known of a turntable's angles before its pictures are asked.
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

/// The angles of --angles, turntable.step or turntable.rpm, the first of these that is given.
class KnownAngles {
 public:
  /// Nothing is known.
  KnownAngles() = default;

  /// Reads --angles. Errors: kConfig, with file and line.
  [[nodiscard]] static Result<KnownAngles> read(const ScanJob& job);

  [[nodiscard]] AngleSource source() const;

  /// False for a step: frames that are missing from the recording are missing from it.
  [[nodiscard]] bool knows_gaps() const { return !file_degrees_.empty() || config_.step_degrees <= 0; }

  /// As the user wrote it: `--angles`, `turntable.step`.
  [[nodiscard]] std::string option() const;

  /// Before any work: whether there is an angle for every frame. A warning where there are more, or nothing.
  /// Errors: kConfig.
  [[nodiscard]] Result<std::optional<std::string>> check(const RecordingInfo& recording) const;

  /// The angle of each frame, up to an offset and turning the way that `seen` does; nothing where nothing is known.
  /// All three have one entry a frame, in order. Errors: kConfig.
  [[nodiscard]] Result<std::optional<AnglePrior>> of(const std::vector<std::uint64_t>& sequences,
                                                     const std::vector<std::int64_t>& times_ns,
                                                     const TurntableMotion& seen) const;

  /// A warning for people, of what the pictures contradict altogether.
  [[nodiscard]] std::string contradiction(const PriorCheck& check) const;
  /// And of single frames.
  [[nodiscard]] std::string frames_off(const std::vector<std::uint64_t>& sequences) const;

 private:
  [[nodiscard]] Error no_times() const;
  [[nodiscard]] Error too_few(std::uint64_t frame) const;

  TurntableConfig config_;
  std::string file_, recording_;  ///< for messages
  std::vector<double> file_degrees_;
  std::uint64_t last_frame_ = 0;  ///< that is asked for
};

/// "frame 15", "frames 15 to 37, 40"; `numbers` grow.
[[nodiscard]] std::string frames_text(const std::vector<std::uint64_t>& numbers);

}  // namespace scanknit
