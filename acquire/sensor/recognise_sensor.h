// Recognises the sensor that made a recording: by what the recording says of itself, else by its depth.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "acquire/frame_source.h"
#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

/// What a recording says of itself.
struct RecordingNames {
  std::string_view format;            ///< RecordingInfo::format
  std::filesystem::path folder = {};  ///< its name, and those of the folders that it lies in, may name a data set
  std::string_view device = {};       ///< the sensor's name; empty: not stated
};

[[nodiscard]] std::optional<RecognisedSensor> sensor_by_name(const RecordingNames& names);

/// Sensors that find depth from a disparity measure it in steps of one size in 1/z, which depends on the sensor. Named
/// is a sensor whose steps and whose camera fit. Rendered pictures, and those of other sensors, have no such steps, nor
/// have pictures without depth beyond the distance where one step is some millimetres.
[[nodiscard]] std::optional<RecognisedSensor> sensor_by_depth(const DepthImage& depth_m,
                                                              const CameraIntrinsics& camera);

/// The size of these steps (1/m); nothing where the picture's depths lie on no such steps.
[[nodiscard]] std::optional<double> disparity_step_per_m(const DepthImage& depth_m);

}  // namespace scanknit
