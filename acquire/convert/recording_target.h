// RecordingTarget: the output of a conversion. Private to the room.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/axes.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// A frame in the form that all targets take.
struct ConvertedFrame {
  const Frame& frame;
  const Image<std::uint16_t>& raw_depth;
  double units_per_metre = 1000;
  std::size_t number = 0;    ///< from 0, without gaps
  std::int64_t time_ns = 0;  ///< thirty frames a second if the recording has no clock
};

class RecordingTarget {
 public:
  virtual ~RecordingTarget() = default;
  /// Why the layout has no place for this frame, which is then left out; nothing: write() takes it.
  [[nodiscard]] virtual std::optional<Error> refuses([[maybe_unused]] const Frame& frame) const { return {}; }
  [[nodiscard]] virtual Result<void> write(const ConvertedFrame& converted) = 0;
  /// To be called after the last frame, when at least one was written.
  [[nodiscard]] virtual Result<void> finish() = 0;

  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  /// Warns; each text only once.
  void warn(const std::string& text);

  /// register_colour(), with a warning.
  [[nodiscard]] ColourImage resample_colour(const Frame& frame);

  /// Writes the frame's colour as `folder`/`stem` with the extension that fits, and returns stem and extension: byte by
  /// byte if it is registered to depth and came from a file, else as a PNG, resampled where it is not registered.
  [[nodiscard]] Result<std::string> write_colour_file(const Frame& frame, const std::filesystem::path& folder,
                                                      const std::string& stem);
  /// The same, never resampled: the picture of the colour camera.
  [[nodiscard]] static Result<std::string> write_own_colour_file(const ColourFrame& colour,
                                                                 const std::filesystem::path& folder,
                                                                 const std::string& stem);

 private:
  std::vector<std::string> warnings_;
};

using OpenedTarget = Result<std::unique_ptr<RecordingTarget>>;

[[nodiscard]] OpenedTarget open_mcap_target(const std::filesystem::path& file);
[[nodiscard]] OpenedTarget open_ros2_target(const std::filesystem::path& file);
// `folder` is new or empty.
[[nodiscard]] OpenedTarget open_tum_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_open3d_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_seven_scenes_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_fakenect_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_colmap_target(const std::filesystem::path& folder);
/// `world_up`: the axis of the recording's world that points up.
[[nodiscard]] OpenedTarget open_nerfstudio_target(const std::filesystem::path& folder, UpAxis world_up);

/// True when colour and depth have the same camera, except its resolution.
[[nodiscard]] bool is_registered(const Frame& frame);

/// The point that depth sees at pixel (x, y), in the depth camera, and its colour; nothing: no depth, or the colour
/// camera does not see the point. `frame` has colour.
struct ColouredPoint {
  Eigen::Vector3d p_depth;
  Rgb8 colour;
};
[[nodiscard]] std::optional<ColouredPoint> coloured_point(const Frame& frame, int x, int y);

/// The frame's colour from the depth camera's view: black where depth is unknown or the colour camera does not see the
/// point. `frame` has colour.
[[nodiscard]] ColourImage register_colour(const Frame& frame);

}  // namespace scanknit
