// The data rates of USB links.
#pragma once

namespace scanknit {

inline constexpr int kSuperSpeedMbit = 5000;  ///< USB 3

/// The practical rate of a high-speed (USB 2) link; the nominal rate is 60 MB/s.
inline constexpr double kHighSpeedBytesPerSecond = 40e6;

}  // namespace scanknit
