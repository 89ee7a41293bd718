#include "acquire/convert/cut_recording.h"

#include <utility>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"

namespace scanknit {

CutRecording::CutRecording(std::unique_ptr<RecordingTarget> target) : target_(std::move(target)) {}
CutRecording::CutRecording(CutRecording&&) noexcept = default;
CutRecording::~CutRecording() = default;

Result<CutRecording> CutRecording::create(const std::filesystem::path& folder) {
  auto target = open_open3d_target(folder);
  if (!target) return target.error();
  return CutRecording(*std::move(target));
}

Result<void> CutRecording::write(const Frame& frame) {
  constexpr double kUnitsPerMetre = 10'000;  // up to 6.5 m
  constexpr std::int64_t kThirtieth_ns = 33'333'333;
  const auto raw = to_raw_depth(frame.depth_m, kUnitsPerMetre);
  const auto number = static_cast<std::int64_t>(written_);
  const std::int64_t time_ns = frame.has_clock ? frame.timestamp_ns : number * kThirtieth_ns;
  return target_->write({frame, raw, kUnitsPerMetre, written_++, time_ns});
}

Result<void> CutRecording::finish() {
  return target_->finish();
}

}  // namespace scanknit
