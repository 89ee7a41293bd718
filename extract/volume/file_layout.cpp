#include "extract/volume/file_layout.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "core/checked_math.h"

namespace scanknit {

void set_sample_type(VolumeHeader& header, SampleType type) {
  header.sample_type = sample_type_name(type);
  if (!is_rounded_to_float(type)) return;
  const char* lost = type == SampleType::kDouble ? "some 7 digits are kept" : "numbers beyond 16777216 are rounded";
  header.warnings.push_back("samples of " + header.sample_type + " become 32-bit floats: " + lost);
}

Result<std::uint64_t> checked_bytes(const std::filesystem::path& path, const VolumeHeader& header, SampleType type) {
  if (header.dims.minCoeff() < 2) {
    return bad_volume(path, dims_text(header.dims) + " samples; a volume has at least 2 along each axis");
  }
  const Eigen::Matrix4d T = header.T_file_index.matrix();
  const Eigen::Matrix3d axes = header.T_file_index.linear();
  // Three axes within a millionth of a plane are no volume; relative, so that any unit will do.
  const double spanned = std::abs(axes.determinant());
  if (!T.allFinite() || !(spanned > 1e-6 * axes.col(0).norm() * axes.col(1).norm() * axes.col(2).norm())) {
    return bad_volume(path, "spacing, directions or origin are not finite numbers that span a volume");
  }
  std::optional<std::uint64_t> bytes = bytes_per_sample(type);
  for (const int dim : header.dims) {
    if (bytes) bytes = checked_mul(*bytes, static_cast<std::uint64_t>(dim));
  }
  // Offsets in files are signed.
  if (!bytes || *bytes > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) / 4) {
    return bad_volume(path, dims_text(header.dims) + " samples are more than any file holds");
  }
  return *bytes;
}

Result<void> check_budget(const std::filesystem::path& path, std::uint64_t needed, std::size_t budget,
                          const std::string& what, const std::string& advice) {
  if (needed <= budget) return {};
  return Error{ErrorCode::kBudget,
               what + " needs " + bytes_text(needed) + ", the memory budget is " + bytes_text(budget) + "; " + advice,
               path.string()};
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr double kMebi = 1 << 20;
  const auto size = static_cast<double>(bytes);
  if (size < kMebi) return std::to_string(bytes) + " bytes";
  char text[32];
  const bool is_large = size >= 1024 * kMebi;
  std::snprintf(text, sizeof text, is_large ? "%.1f GiB" : "%.1f MiB", size / (is_large ? 1024 * kMebi : kMebi));
  return text;
}

std::string dims_text(const Eigen::Vector3i& dims) {
  return std::to_string(dims.x()) + " x " + std::to_string(dims.y()) + " x " + std::to_string(dims.z());
}

}  // namespace scanknit
