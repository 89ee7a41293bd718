// RecordingTarget: where a converted recording goes. Private to the room.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// A frame as every target wants it.
struct ConvertedFrame {
  const Frame& frame;
  const Image<std::uint16_t>& raw_depth;
  double units_per_metre = 1000;
  std::size_t number = 0;    ///< counting from 0 without gaps
  std::int64_t time_ns = 0;  ///< thirty frames a second where the recording has no clock
};

class RecordingTarget {
 public:
  virtual ~RecordingTarget() = default;
  [[nodiscard]] virtual Result<void> write(const ConvertedFrame& converted) = 0;
  /// After the last frame; at least one was written.
  [[nodiscard]] virtual Result<void> finish() = 0;

  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  /// Once each.
  void warn(const std::string& text);

  /// register_colour(), with a warning.
  [[nodiscard]] ColourImage resample_colour(const Frame& frame);

 private:
  std::vector<std::string> warnings_;
};

using OpenedTarget = Result<std::unique_ptr<RecordingTarget>>;

[[nodiscard]] OpenedTarget open_mcap_target(const std::filesystem::path& file);
// Folders that are new or empty.
[[nodiscard]] OpenedTarget open_tum_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_open3d_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_seven_scenes_target(const std::filesystem::path& folder);
[[nodiscard]] OpenedTarget open_fakenect_target(const std::filesystem::path& folder);

/// True when colour is seen from where depth is, by the same camera but for its resolution.
[[nodiscard]] bool is_registered(const Frame& frame);

/// The frame's colour as its depth camera sees it: black where depth is unknown or colour was not in view. `frame` has
/// colour.
[[nodiscard]] ColourImage register_colour(const Frame& frame);

}  // namespace scanknit
