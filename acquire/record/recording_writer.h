// RecordingWriter: raw frames, and what explains them, as the messages of an MCAP file.
#pragma once

#include <cstdint>
#include <string_view>

#include "acquire/mcap/mcap_writer.h"
#include "acquire/raw_frame.h"
#include "acquire/record/recording_channels.h"
#include "core/result.h"

namespace scanknit {

/// Not thread-safe. A failed call lost what was waiting (see frames_waiting); what was written before is whole.
class RecordingWriter {
 public:
  RecordingWriter(ByteSink sink, RawCalibration calibration);

  [[nodiscard]] Result<void> begin() { return mcap_.begin(); }

  /// Into the chunk that is being filled; a chunk of a mebibyte or of 0.4 s of host time is written. The calibration
  /// goes into the first two chunks, one of which may be damaged, and is repeated every ten seconds of host time.
  [[nodiscard]] Result<void> write(const RawFrame& frame);

  /// `at` gives the times. The pose of the depth picture `at.sequence`.
  void write_pose(const RawFrame& at, const Pose& T_world_camera);
  void write_losses(std::int64_t host_ns, const LossCounters& losses);

  /// Frames that are not yet written.
  [[nodiscard]] std::uint64_t frames_waiting() const { return frames_waiting_; }
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> finish();

 private:
  void add(RecordingChannel channel, std::uint64_t sequence, std::int64_t host_ns, std::int64_t device_ns,
           std::span<const std::byte> data);
  void add_text(RecordingChannel channel, std::uint64_t sequence, std::int64_t host_ns, std::int64_t device_ns,
                std::string_view text);

  McapWriter mcap_;
  RawCalibration calibration_;
  std::uint64_t calibrations_ = 0;
  std::uint64_t losses_ = 0;
  std::int64_t calibrated_at_ns_ = 0;
  std::int64_t chunk_begin_ns_ = 0;  // of the first frame in it
  std::uint64_t frames_waiting_ = 0;
};

}  // namespace scanknit
