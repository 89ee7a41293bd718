#include "scan/refine/known_angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/rotation.h"
#include "scan/refine/angle_file.h"

namespace scanknit {
namespace {

/// Removes the jumps of an encoder that begins again at 0 after a turn. Assumes that no step is more than half a turn.
void unwrap(std::vector<double>& angles) {
  for (std::size_t i = 1; i < angles.size(); ++i) {
    angles[i] = angles[i - 1] + wrapped(angles[i] - angles[i - 1]);
  }
}

/// Gives `angles` the sign of the motion `seen`: the encoder and the scanner may count in opposite directions. Compares
/// small steps only; at a large one tracking may have failed.
void turn_as_seen(const TurntableMotion& seen, std::vector<double>& angles) {
  static constexpr double kMost_rad = 3 * kDegree;
  const auto small = [](double step_rad) { return std::clamp(step_rad, -kMost_rad, kMost_rad); };
  double along = 0;
  for (std::size_t i = 1; i < angles.size(); ++i) {
    along += small(angles[i] - angles[i - 1]) * small(seen.angles_rad[i] - seen.angles_rad[i - 1]);
  }
  if (along >= 0) return;
  for (double& angle : angles) angle = -angle;
}

}  // namespace

Result<KnownAngles> KnownAngles::read(const ScanJob& job) {
  KnownAngles known;
  known.config_ = job.config.turntable;
  known.recording_ = job.input.string();
  known.last_frame_ = job.config.acquire.to;
  if (job.angles) {
    auto degrees = read_angle_file(*job.angles);
    if (!degrees) return degrees.error();
    known.file_ = job.angles->string();
    known.file_degrees_ = *std::move(degrees);
  }
  return known;
}

AngleSource KnownAngles::source() const {
  if (!file_degrees_.empty()) return AngleSource::kFile;
  if (config_.step_degrees > 0) return AngleSource::kStep;
  return config_.rpm > 0 ? AngleSource::kRpm : AngleSource::kNone;
}

std::string KnownAngles::option() const {
  switch (source()) {
    case AngleSource::kFile: return "the angle file";
    case AngleSource::kStep: return "turntable.step";
    case AngleSource::kRpm: return "turntable.rpm";
    default: return "turntable.none";
  }
}

Error KnownAngles::no_times() const {
  return {ErrorCode::kConfig, "turntable.rpm: the recording has no times; give turntable.step", recording_};
}

Error KnownAngles::too_few(std::uint64_t frame) const {
  return {ErrorCode::kConfig, fmt::format("has {} angles, but there is a frame {}", file_degrees_.size(), frame),
          file_};
}

Result<std::optional<std::string>> KnownAngles::check(const RecordingInfo& recording) const {
  if (source() == AngleSource::kRpm && !recording.duration_s) return no_times();
  if (file_degrees_.empty() || recording.frames == 0) return std::optional<std::string>();
  const std::uint64_t last = std::min<std::uint64_t>(recording.frames - 1, last_frame_);
  if (file_degrees_.size() <= last) return too_few(last);
  if (file_degrees_.size() == recording.frames) return std::optional<std::string>();
  return std::optional(fmt::format("{}: has {} angles for {} frames; those at the end are left out", file_,
                                   file_degrees_.size(), recording.frames));
}

Result<std::optional<AnglePrior>> KnownAngles::of(const std::vector<std::uint64_t>& sequences,
                                                  const std::vector<std::int64_t>& times_ns,
                                                  const TurntableMotion& seen) const {
  AnglePrior prior;
  prior.sigma_rad = config_.angle_sigma_degrees * kDegree;
  if (!file_degrees_.empty()) {
    for (const std::uint64_t sequence : sequences) {
      if (sequence >= file_degrees_.size()) return too_few(sequence);
      prior.angles_rad.push_back(file_degrees_[sequence] * kDegree);
    }
    unwrap(prior.angles_rad);
  } else if (config_.step_degrees > 0) {
    for (const std::uint64_t sequence : sequences) {
      prior.angles_rad.push_back(static_cast<double>(sequence) * config_.step_degrees * kDegree);
    }
  } else if (config_.rpm > 0) {
    for (const std::int64_t time_ns : times_ns) {
      const double minutes = static_cast<double>(time_ns - times_ns.front()) / 60e9;
      prior.angles_rad.push_back(minutes * config_.rpm * kFullTurn);
    }
  } else {
    return std::optional<AnglePrior>();
  }
  turn_as_seen(seen, prior.angles_rad);
  return std::optional(std::move(prior));
}

std::string KnownAngles::contradiction(const PriorCheck& check) const {
  const std::string rest =
      fmt::format("they differ by {:.1f} degrees, and turntable.angle_sigma allows {:g}; the known angles are not used",
                  check.typical_off_rad / kDegree, config_.angle_sigma_degrees);
  if (!file_degrees_.empty()) {
    return fmt::format("{}: the pictures contradict these angles, they turn {:.3g} times as far: {}", file_,
                       check.scale, rest);
  }
  if (config_.step_degrees > 0) {
    return fmt::format("turntable.step is {:g} degrees, but the pictures turn by {:.2f}: {}", config_.step_degrees,
                       check.scale * config_.step_degrees, rest);
  }
  return fmt::format("turntable.rpm is {:g}, but the pictures turn {:.3f} times a minute: {}", config_.rpm,
                     check.scale * config_.rpm, rest);
}

std::string KnownAngles::frames_off(const std::vector<std::uint64_t>& sequences) const {
  const std::string frames = frames_text(sequences);
  if (file_degrees_.empty()) {
    return fmt::format("the pictures contradict {} at {}; there the angles in the pictures are used", option(), frames);
  }
  const bool is_one = sequences.size() == 1;
  return fmt::format("{}: the pictures contradict the {} of {} ({}{:.6g} degrees); the angles in the pictures are used",
                     file_, is_one ? "angle" : "angles", frames, is_one ? "" : "the first is ",
                     file_degrees_[sequences.front()]);
}

std::string frames_text(const std::vector<std::uint64_t>& numbers) {
  std::string text = numbers.size() == 1 ? "frame " : "frames ";
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (begin > 0) text += ", ";
    text += std::to_string(numbers[begin]);
    if (end - begin > 1) text += fmt::format(" to {}", numbers[end - 1]);
    begin = end;
  }
  return text;
}

}  // namespace scanknit
