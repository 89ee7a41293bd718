// RecordingWriter: writes raw frames and their calibration as messages of an MCAP file.
#pragma once

#include <cstdint>
#include <string_view>

#include "acquire/mcap/mcap_writer.h"
#include "acquire/raw_frame.h"
#include "acquire/record/raw_frame_writer.h"
#include "acquire/record/recording_channels.h"
#include "core/result.h"

namespace scanknit {

class RecordingWriter final : public RawFrameWriter {
 public:
  RecordingWriter(ByteSink sink, RawCalibration calibration);

  [[nodiscard]] Result<void> begin() override { return mcap_.begin(); }

  /// Adds the frame to the current chunk, which is written when it has a mebibyte or 0.4 s of host time. The
  /// calibration is in the first two chunks, in case one is damaged, and again every ten seconds of host time.
  [[nodiscard]] Result<void> write(const RawFrame& frame) override;

  /// Writes the pose of the depth picture `at.sequence`; `at` gives the times.
  void write_pose(const RawFrame& at, const Pose& T_world_camera);
  void write_losses(std::int64_t host_ns, const LossCounters& losses) override;

  [[nodiscard]] std::uint64_t frames_waiting() const override { return frames_waiting_; }
  [[nodiscard]] Result<void> flush() override;
  [[nodiscard]] Result<void> finish() override;

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
