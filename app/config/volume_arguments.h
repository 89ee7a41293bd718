// Parses the options that describe a volume's samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>

namespace scanknit {

/// "256x256x108": whole numbers > 0.
[[nodiscard]] std::optional<Eigen::Vector3i> parse_dims(std::string_view text);

/// "0.5x0.5x1.2", or "0.5" for all three axes: millimetres, finite, > 0.
[[nodiscard]] std::optional<Eigen::Vector3d> parse_spacing(std::string_view text);

/// "352": a whole number >= 0.
[[nodiscard]] std::optional<std::uint64_t> parse_header_bytes(std::string_view text);

}  // namespace scanknit
