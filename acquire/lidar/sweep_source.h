// SweepSource: a recording of LiDAR sweeps whose poses are known.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/axes.h"
#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// One turn of the scanner, as if all of its points had been measured from one place.
struct Sweep {
  std::uint64_t sequence = 0;                     ///< its place in the recording, from 0
  std::optional<std::int64_t> timestamp_ns = {};  ///< nothing: the recording has no clock
  std::vector<Eigen::Vector3f> points_m = {};     ///< finite, in the sensor's frame: x forward, y left, z up
  std::vector<std::uint16_t> rings = {};          ///< the laser of each point; empty: unknown
  /// When each point was measured, after `timestamp_ns`; empty: unknown, or all at once.
  std::vector<std::int64_t> offsets_ns = {};
  Pose T_world_sensor = Pose::Identity();  ///< at `timestamp_ns`
};

/// What is known of a recording without reading its sweeps.
struct SweepInfo {
  std::string format;  ///< "kitti"
  std::filesystem::path folder;
  std::size_t sweeps = 0;
  std::size_t sweeps_with_pose = 0;
  std::optional<double> duration_s = {};  ///< nothing: the recording has no clock
  UpAxis world_up = UpAxis::kMinusY;
  std::string expected_poses;  ///< for messages: where poses are looked for
  std::vector<std::string> warnings = {};
  std::map<std::string, std::string> topics = {};  ///< of a bag of ROS, as RecordingInfo::topics; "depth": the sweeps
};

/// One consumer; not thread-safe. Holds one sweep at a time.
class SweepSource {
 public:
  virtual ~SweepSource() = default;

  [[nodiscard]] virtual const SweepInfo& info() const = 0;

  /// Reads one sweep, `index` < info().sweeps. One that cannot be used is dropped, with the reason.
  [[nodiscard]] virtual std::variant<Sweep, FrameDropped> read(std::size_t index) = 0;
};

/// True where open_sweeps() would read `path`. Looks at names and first bytes only.
[[nodiscard]] bool is_sweep_recording(const std::filesystem::path& path, const AcquireConfig& config);

/// Opens a recording of sweeps. A recording without poses is opened, too; all its sweeps are dropped then. Errors
/// (kInput): no such recording; no sweep; calibration or poses that cannot be read. Error (kConfig): config.camera is
/// given.
[[nodiscard]] Result<std::unique_ptr<SweepSource>> open_sweeps(const std::filesystem::path& path,
                                                               const AcquireConfig& config);

}  // namespace scanknit
