// Ros2RecordingWriter: writes raw frames and their calibration as messages of ROS 2 in an MCAP file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "acquire/record/raw_frame_writer.h"
#include "acquire/ros2/ros2_bag_writer.h"

namespace scanknit {

/// Pictures stay as the scanner sends them: depth as Image of 16UC1 (32FC1 where its unit is not a millimetre), colour
/// as Image, or as CompressedImage where it is MJPEG; beside each picture its CameraInfo with the lens, and tf_static
/// with the colour camera's place. Cameras that are not known have none. Losses are not in the file: there is no
/// message for them.
class Ros2RecordingWriter final : public RawFrameWriter {
 public:
  /// `streams`: those that will be written.
  Ros2RecordingWriter(ByteSink sink, RawCalibration calibration, std::span<const StreamProfile> streams);

  [[nodiscard]] Result<void> begin() override { return bag_.begin(); }
  [[nodiscard]] Result<void> write(const RawFrame& frame) override;
  void write_losses(std::int64_t /*host_ns*/, const LossCounters& /*losses*/) override {}
  [[nodiscard]] std::uint64_t frames_waiting() const override { return frames_waiting_; }
  [[nodiscard]] Result<void> flush() override;
  [[nodiscard]] Result<void> finish() override;

 private:
  void set_time(const RawFrame& frame);
  void add_depth(const RawFrame& frame);
  void add_colour(const RawFrame& frame);

  Ros2BagWriter bag_;
  RawCalibration calibration_;
  std::int64_t day_minus_host_ns_;                   ///< from this computer's steady clock to its time of day
  std::optional<std::int64_t> day_minus_device_ns_;  ///< from the camera's clock
  std::optional<std::int64_t> transform_at_ns_;      ///< when tf_static was written last, host's clock
  std::int64_t chunk_begin_ns_ = 0;                  ///< of the first frame in it
  std::uint64_t frames_waiting_ = 0;
};

}  // namespace scanknit
