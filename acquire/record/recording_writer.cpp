#include "acquire/record/recording_writer.h"

#include <span>
#include <utility>

#include "acquire/record/picture_message.h"

namespace scanknit {
namespace {

// A quarter of a second of a depth camera with colour: few enough bytes that a torn file loses little, enough that the
// index and the repeated channels (4 kB a chunk) do not count.
constexpr std::size_t kChunkBytes = 1u << 20;
constexpr std::uint64_t kChunkPeriod_ns = 400'000'000;
constexpr std::uint64_t kCalibrationPeriod_ns = 10'000'000'000;

// Between two times that may be anything. The streams' stamps need not ascend together: what lies before is no time
// ago.
std::uint64_t time_since(std::int64_t before_ns, std::int64_t now_ns) {
  return now_ns < before_ns ? 0 : static_cast<std::uint64_t>(now_ns) - static_cast<std::uint64_t>(before_ns);
}

}  // namespace

RecordingWriter::RecordingWriter(ByteSink sink, RawCalibration calibration)
    : mcap_(std::move(sink), recording_schemas(), recording_channels()), calibration_(std::move(calibration)) {}

Result<void> RecordingWriter::write(const RawFrame& frame) {
  const bool begins_second_chunk = calibrations_ == 1 && frames_waiting_ == 0;
  if (calibrations_ == 0 || begins_second_chunk ||
      time_since(calibrated_at_ns_, frame.host_ns) >= kCalibrationPeriod_ns) {
    add_text(RecordingChannel::kCalibration, calibrations_++, frame.host_ns, frame.device_ns,
             calibration_text(calibration_));
    calibrated_at_ns_ = frame.host_ns;
  }
  const bool is_depth = frame.profile.kind == StreamKind::kDepth;
  add(is_depth ? RecordingChannel::kDepth : RecordingChannel::kColour, frame.sequence, frame.host_ns, frame.device_ns,
      pack_picture(frame));
  if (frames_waiting_++ == 0) chunk_begin_ns_ = frame.host_ns;
  const bool is_full =
      mcap_.waiting_bytes() >= kChunkBytes || time_since(chunk_begin_ns_, frame.host_ns) >= kChunkPeriod_ns;
  return is_full ? flush() : Result<void>{};
}

void RecordingWriter::write_pose(const RawFrame& at, const Pose& T_world_camera) {
  add_text(RecordingChannel::kPose, at.sequence, at.host_ns, at.device_ns, pose_text(at.sequence, T_world_camera));
}

void RecordingWriter::write_losses(std::int64_t host_ns, const LossCounters& losses) {
  add_text(RecordingChannel::kLosses, losses_++, host_ns, host_ns, losses_text(losses));
}

Result<void> RecordingWriter::flush() {
  frames_waiting_ = 0;
  return mcap_.flush();
}

Result<void> RecordingWriter::finish() {
  frames_waiting_ = 0;
  return mcap_.finish();
}

void RecordingWriter::add_text(RecordingChannel channel, std::uint64_t sequence, std::int64_t host_ns,
                               std::int64_t device_ns, std::string_view text) {
  add(channel, sequence, host_ns, device_ns, std::as_bytes(std::span(text)));
}

void RecordingWriter::add(RecordingChannel channel, std::uint64_t sequence, std::int64_t host_ns,
                          std::int64_t device_ns, std::span<const std::byte> data) {
  mcap_.add({.channel = static_cast<std::uint16_t>(channel),
             .sequence = static_cast<std::uint32_t>(sequence),  // the whole number is in the picture's own header
             .log_ns = static_cast<std::uint64_t>(host_ns),
             .publish_ns = static_cast<std::uint64_t>(device_ns),
             .data = data});
}

}  // namespace scanknit
