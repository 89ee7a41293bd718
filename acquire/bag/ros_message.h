// A message of ROS as its bytes, and how these are to be read.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace scanknit {

/// How a bag's messages are written.
enum class RosEncoding {
  kCdr,   ///< of ROS 2
  kRos1,  ///< of ROS 1 (wiki.ros.org/msg): little endian, nothing aligned, a number in front of the header's time
};

struct RosMessage {
  // NOLINTBEGIN(google-explicit-constructor): bytes of which nothing else is said are those of ROS 2
  RosMessage(std::span<const std::byte> of, RosEncoding as = RosEncoding::kCdr) : bytes(of), encoding(as) {}
  RosMessage(const std::vector<std::byte>& of) : bytes(of) {}
  // NOLINTEND(google-explicit-constructor)

  std::span<const std::byte> bytes;
  RosEncoding encoding = RosEncoding::kCdr;
};

}  // namespace scanknit
