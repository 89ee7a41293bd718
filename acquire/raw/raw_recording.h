// Makes the index of a Recording from raw frames in one file. Private to the room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/mcap/random_access.h"
#include "acquire/raw_frame.h"
#include "acquire/replay/recording.h"
#include "core/result.h"

namespace scanknit {

class BagMessages;
class PairDepth;

/// The properties of a picture that are known before it is read.
struct RawStamp {
  std::uint64_t sequence = 0;
  std::int64_t device_ns = 0;
};

/// Reads the i-th picture of a stream of `RawRecording`, from 0.
using ReadRawFrame = std::function<Result<RawFrame>(StreamKind, std::size_t)>;

struct RawRecording {
  const char* format = "";
  std::filesystem::path file = {};
  RawCalibration calibration = {};
  std::vector<RawStamp> depth = {}, colour = {};              ///< in the order of the file
  std::map<std::uint64_t, Result<Pose>> T_world_camera = {};  ///< by the depth picture's sequence number
  std::vector<std::string> warnings = {};
  ReadRawFrame read = {};
  std::shared_ptr<const PairDepth> pairs = {};  ///< its depth pictures are pairs (PixelFormat::kY8i)
};

/// A frame for each depth picture, with the colour picture nearest to it in the camera's time (replay/frame_pairing.h),
/// decoded as live capture decodes it (raw_decode.h). The camera of `config` overrides the recording's.
[[nodiscard]] Recording index_raw_recording(RawRecording raw, const AcquireConfig& config);

// fits_*: true if the file's first bytes have this format. index_*: lists its frames; `path` is for messages. Errors
// (kInput) name it.

[[nodiscard]] bool fits_mcap(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_mcap(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                           const AcquireConfig& config);

[[nodiscard]] bool fits_ros2(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_ros2(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                           const AcquireConfig& config);
/// The bag of ROS, one file or a folder of parts, that open_recording() would read at `path`, where that is a bag's
/// file or a folder in which one lies; nothing: it would read something else.
[[nodiscard]] std::optional<std::filesystem::path> find_bag(const std::filesystem::path& path,
                                                            const AcquireConfig& config);

/// Of a bag whose files are open.
[[nodiscard]] Result<Recording> index_bag(std::unique_ptr<BagMessages> messages, const std::filesystem::path& path,
                                          const AcquireConfig& config);

[[nodiscard]] bool fits_sens(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_sens(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                           const AcquireConfig& config);

[[nodiscard]] bool fits_record3d(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_record3d(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                               const AcquireConfig& config);

/// Recordings of Azure Kinect's recorder, which Orbbec's Femto cameras write, too: Matroska with depth, as the device's
/// software computed it, colour, and the calibration. Errors also: there is no depth, or its camera is not known.
[[nodiscard]] bool fits_azure_mkv(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_azure_mkv(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                                const AcquireConfig& config);

[[nodiscard]] bool fits_oni(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_oni(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                          const AcquireConfig& config);

[[nodiscard]] bool fits_ros1(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_ros1(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                           const AcquireConfig& config);

/// A bag of ROS 1 that is not RealSense's is index_ros1()'s.
[[nodiscard]] bool fits_realsense_bag(const RandomAccess& file);
[[nodiscard]] Result<Recording> index_realsense_bag(std::unique_ptr<RandomAccess> file,
                                                    const std::filesystem::path& path, const AcquireConfig& config);

}  // namespace scanknit
