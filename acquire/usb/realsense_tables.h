// The answers of a RealSense D400 camera's hardware monitor: identity and calibration tables, as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

enum class RealsenseOpcode : std::uint32_t { kIdentity = 0x10, kReadTable = 0x15, kReadAdvanced = 0x2C };

inline constexpr std::uint32_t kDepthTable = 25;
inline constexpr std::uint32_t kColourTable = 32;
inline constexpr std::uint32_t kDepthTableControl = 9;  ///< one of the advanced controls

/// A hardware monitor command: length, magic, opcode and four parameters.
[[nodiscard]] std::vector<std::byte> encode_command(RealsenseOpcode opcode, std::uint32_t parameter = 0);

/// The answer's data. Errors (kDevice): shorter than the opcode's echo; another opcode than requested, by which the
/// firmware reports an error code.
[[nodiscard]] Result<std::span<const std::byte>> decode_reply(RealsenseOpcode opcode, std::span<const std::byte> reply);

struct RealsenseIdentity {
  std::string firmware;  ///< "5.12.7.100"
  std::string serial;    ///< twelve hexadecimal digits, as printed on the camera
};
[[nodiscard]] Result<RealsenseIdentity> parse_identity(std::span<const std::byte> data);

/// The depth camera at one of the resolutions in the table; depth pictures are rectified, without distortion. Errors
/// (kDevice): truncated, a wrong checksum, a resolution that the table does not have or whose values are not plausible.
[[nodiscard]] Result<CameraIntrinsics> parse_depth_table(std::span<const std::byte> table, int width, int height);

/// Metres between the two infrared cameras, from the same table. Their rectified pictures have the depth camera's
/// intrinsics. Errors (kDevice): truncated, a wrong checksum, no plausible length.
[[nodiscard]] Result<double> parse_baseline(std::span<const std::byte> table);

/// Metres of one raw unit, from the answer to kReadAdvanced of kDepthTableControl. Errors (kDevice): truncated, or no
/// plausible unit.
[[nodiscard]] Result<double> parse_depth_unit(std::span<const std::byte> data);

struct RealsenseColour {
  CameraModel camera;
  Pose T_colour_depth = Pose::Identity();
};
/// The colour camera at any size, and its pose. Errors as above.
[[nodiscard]] Result<RealsenseColour> parse_colour_table(std::span<const std::byte> table, int width, int height);

}  // namespace scanknit
