// A ball of known size in files of every format, written byte by byte.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace scanknit {

/// Samples 1000 - 80 r, r mm from the middle of the volume: isovalue 600 is a sphere of 5 mm radius.
struct Ball {
  std::array<int, 3> dims = {24, 20, 16};
  std::array<double, 3> spacing_mm = {0.5, 0.75, 1.0};

  [[nodiscard]] std::uint16_t sample(int i, int j, int k) const;
  /// All samples, i fastest, 16 bits each.
  [[nodiscard]] std::string bytes(bool is_big_endian = false) const;
  [[nodiscard]] std::string slice(int k, bool is_big_endian = false) const;
  /// "24x20x16" and "0.5x0.75x1".
  [[nodiscard]] std::string dims_option() const;
  [[nodiscard]] std::string spacing_option() const;
};

inline constexpr double kBallRadiusMm = 5;
inline constexpr const char* kBallIsovalue = "600";
/// Where the files that know an origin put sample (0, 0, 0).
inline constexpr std::array<double, 3> kBallOriginMm = {10, 20, 30};

void write_raw(const Ball& ball, const std::filesystem::path& path, bool is_big_endian = false);
void write_nrrd(const Ball& ball, const std::filesystem::path& path);
void write_meta_image(const Ball& ball, const std::filesystem::path& path);
void write_nifti(const Ball& ball, const std::filesystem::path& path);
void write_dicom_series(const Ball& ball, const std::filesystem::path& folder);
void write_tiff_stack(const Ball& ball, const std::filesystem::path& folder);

}  // namespace scanknit
