#include "app/config/volume_arguments.h"

#include <limits>
#include <vector>

#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

std::vector<std::string_view> split_at_x(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t x = text.find('x'); x != std::string_view::npos; x = text.find('x')) {
    parts.push_back(text.substr(0, x));
    text.remove_prefix(x + 1);
  }
  parts.push_back(text);
  return parts;
}

}  // namespace

std::optional<Eigen::Vector3i> parse_dims(std::string_view text) {
  const auto parts = split_at_x(text);
  if (parts.size() != 3) return std::nullopt;
  Eigen::Vector3i dims;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto count = parse_integer(parts[static_cast<std::size_t>(axis)]);
    if (!count || *count < 1 || *count > std::numeric_limits<int>::max()) return std::nullopt;
    dims[axis] = static_cast<int>(*count);
  }
  return dims;
}

std::optional<Eigen::Vector3d> parse_spacing(std::string_view text) {
  const auto parts = split_at_x(text);
  if (parts.size() != 1 && parts.size() != 3) return std::nullopt;
  Eigen::Vector3d spacing;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto millimetres = parse_finite(parts.size() == 1 ? parts[0] : parts[static_cast<std::size_t>(axis)]);
    if (!millimetres || *millimetres <= 0) return std::nullopt;
    spacing[axis] = *millimetres;
  }
  return spacing;
}

std::optional<std::uint64_t> parse_header_bytes(std::string_view text) {
  const auto bytes = parse_integer(text);
  if (!bytes || *bytes < 0) return std::nullopt;
  return static_cast<std::uint64_t>(*bytes);
}

}  // namespace scanknit
