// PNG and JPEG files of every kind that libpng and libjpeg write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"

namespace scanknit::test {

using Bytes = std::vector<std::byte>;

struct Size {
  int width = 0;
  int height = 0;
};

/// Samples as a picture has them: `is_smooth` as of a lens, else noise. `channels` a pixel, row by row.
[[nodiscard]] std::vector<std::uint8_t> samples(Size size, int channels, bool is_smooth, std::mt19937& random);

[[nodiscard]] ColourImage colour_sample(Size size, bool is_smooth, std::mt19937& random);
[[nodiscard]] Image<std::uint16_t> depth_sample(Size size, bool is_smooth, std::mt19937& random);

struct PngKind {
  int colour_type = 0;  ///< of the specification: 0 grey, 2 RGB, 3 palette, 4 grey with alpha, 6 RGB with alpha
  int bit_depth = 0;
  bool is_interlaced = false;
  bool has_colour_key = false;  ///< a tRNS chunk, and an orientation in an eXIf chunk
};

[[nodiscard]] std::vector<PngKind> all_png_kinds();
[[nodiscard]] std::string name_of(const PngKind& kind);
[[nodiscard]] Bytes png_file(const PngKind& kind, Size size, std::mt19937& random);

struct JpegKind {
  std::string name;
  int components = 3;
  int in_space = 0, file_space = 0;  ///< libjpeg's J_COLOR_SPACE: of the samples, of the file
  int h_sampling = 2, v_sampling = 2;
  bool is_progressive = false;
  bool is_arithmetic = false;
  unsigned restart_interval = 0;
  bool has_orientation = false;  ///< an Exif segment: turned by a quarter
};

[[nodiscard]] std::vector<JpegKind> all_jpeg_kinds();
[[nodiscard]] Bytes jpeg_file(const JpegKind& kind, Size size, int quality, bool is_smooth, std::mt19937& random);

/// Without its DHT segments, as the pictures of cameras are.
[[nodiscard]] Bytes without_huffman_tables(const Bytes& jpeg);

/// The same chunks with CRCs that are right.
void repair_crcs(Bytes& png);

}  // namespace scanknit::test
