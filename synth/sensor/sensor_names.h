// The sensors that the synthetic scanner can be.
#pragma once

#include <array>
#include <string_view>

namespace scanknit {

/// ideal: exact, every effect off. kinect1: structured light (Kinect v1, Xtion). d435: stereo with a projector. And
/// phone_lidar: depth that a phone makes of a few hundred time-of-flight points.
inline constexpr std::array<std::string_view, 4> kSensorNames = {"ideal", "kinect1", "d435", "phone_lidar"};

}  // namespace scanknit
