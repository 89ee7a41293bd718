// From exact depth to the depth that a RenderedSensor reports.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "core/image.h"
#include "synth/render.h"
#include "synth/sensor/rendered_sensor.h"

namespace scanknit {

/// The seed belongs to the unit (its bias) as well as to the noise, of which each picture has its own. A pure function,
/// the same for any number of threads. The ideal sensor returns the exact depth, bit by bit.
[[nodiscard]] DepthImage sense_depth(const RenderedView& view, const CameraIntrinsics& camera,
                                     const RenderedSensor& sensor, std::uint64_t seed, std::uint64_t frame);

}  // namespace scanknit
