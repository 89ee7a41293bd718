// What USB links carry.
#pragma once

namespace scanknit {

inline constexpr int kSuperSpeedMbit = 5000;  ///< USB 3

/// What a high-speed (USB 2) link carries in practice, of 60 MB/s on paper.
inline constexpr double kHighSpeedBytesPerSecond = 40e6;

}  // namespace scanknit
