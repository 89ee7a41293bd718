// IndexedSource: plays a Recording. It has the code that is common to all layouts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "acquire/masks/found_masks.h"
#include "acquire/replay/recording.h"
#include "acquire/replay/skipping_source.h"
#include "acquire/sensor/depth_bias.h"

namespace scanknit {

/// Selects frames, decodes them, determines camera and pose, and drops unusable frames. The first picture among the
/// selected frames that can be decoded sets the size that all others must have.
class IndexedSource final : public SkippingSource {
 public:
  /// `config` is valid and its from/to/every select at least one entry of `recording`. `empty`: of
  /// read_empty_picture().
  IndexedSource(Recording recording, const AcquireConfig& config, EmptyPicture empty);

  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;
  void skip_until(const std::function<bool(std::uint64_t sequence)>& is_wanted) override;

  // Out of order; `index` < info().frames.
  [[nodiscard]] FrameEvent frame(std::size_t index);
  [[nodiscard]] bool has_clock() const { return has_clock_; }
  /// Nothing without a clock, and for a frame that is dropped and has none.
  [[nodiscard]] std::optional<std::int64_t> time_of(std::size_t index) const {
    return has_clock_ ? recording_.entries[index].timestamp_ns : std::nullopt;
  }

 private:
  void go_on();
  [[nodiscard]] OrDrop<Frame> load(std::size_t index);
  void correct_depth(Frame& frame);
  [[nodiscard]] OrDrop<Frame> load_pictures(const FrameEntry& entry, std::optional<Result<Pose>>& pose) const;
  [[nodiscard]] std::filesystem::path masks_folder() const {
    return (recording_.folder / *config_.masks).lexically_normal();
  }
  [[nodiscard]] std::filesystem::path mask_of(const FrameEntry& entry) const;
  [[nodiscard]] DecodeSettings decode_settings(const FrameEntry& entry) const;
  [[nodiscard]] OrDrop<Mask> read_mask_file(const FrameEntry& entry) const;
  [[nodiscard]] OrDrop<Mask> find_mask_in_colour(const FrameEntry& entry, const DecodedFrame& decoded,
                                                 const CameraIntrinsics& depth_camera) const;
  [[nodiscard]] std::optional<Drop> use_mask(const FrameEntry& entry, const DecodedFrame& decoded,
                                             const Distortion& distortion, Frame& frame) const;
  [[nodiscard]] std::optional<Drop> settle_pose(const FrameEntry& entry, const std::optional<Result<Pose>>& pose,
                                                Frame& frame) const;
  void describe();
  void look_at_first_frames();
  void look_at_masks();

  Recording recording_;
  AcquireConfig config_;
  MaskOrigin masks_;
  EmptyPicture empty_;
  RecordingInfo info_;
  std::optional<DepthCorrection> correction_;  ///< of all frames: they have one size
  bool has_clock_ = false;
  std::size_t next_ = 0;
  std::size_t last_ = 0;  // inclusive
  bool is_at_end_ = false;
};

/// open_recording()'s.
[[nodiscard]] Result<std::unique_ptr<IndexedSource>> open_indexed(const std::filesystem::path& path,
                                                                  const AcquireConfig& config);

}  // namespace scanknit
