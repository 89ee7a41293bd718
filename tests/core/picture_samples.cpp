#include "tests/core/picture_samples.h"

#include <png.h>

#include <cstdio>

#include <jpeglib.h>

#include <array>
#include <cmath>
#include <cstdlib>

#include "core/files/crc32.h"

namespace scanknit::test {
namespace {

// TIFF, big-endian, with one entry: orientation (0x0112), one short, 6: turned by a quarter.
constexpr std::array<unsigned char, 26> kTurned = {'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 1, 18, 0,
                                                   3,   0,   0, 0,  1, 0, 6, 0, 0, 0, 0, 0,  0};

void append(png_structp png, png_bytep from, std::size_t count) {
  auto& bytes = *static_cast<Bytes*>(png_get_io_ptr(png));
  const auto added = std::as_bytes(std::span(from, count));
  bytes.insert(bytes.end(), added.begin(), added.end());
}

std::uint32_t big_endian_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

void add_colour_key(png_structp png, png_infop info, const PngKind& kind) {
  std::array<png_byte, 2> alpha = {0, 128};
  png_color_16 key{};
  key.gray = key.red = key.green = key.blue = 1;
  const bool is_palette = kind.colour_type == PNG_COLOR_TYPE_PALETTE;
  png_set_tRNS(png, info, is_palette ? alpha.data() : nullptr, is_palette ? 2 : 0, is_palette ? nullptr : &key);
  auto turned = kTurned;
  png_set_eXIf_1(png, info, static_cast<png_uint_32>(turned.size()), turned.data());
}

}  // namespace

std::vector<std::uint8_t> samples(Size size, int channels, bool is_smooth, std::mt19937& random) {
  std::vector<std::uint8_t> made;
  const double phase = std::uniform_real_distribution<>(0, 6)(random);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        const double smooth = 127.5 + 127.5 * std::sin(phase + 0.05 * x + 0.07 * y + 2 * c);
        made.push_back(is_smooth ? static_cast<std::uint8_t>(smooth) : static_cast<std::uint8_t>(random()));
      }
    }
  }
  return made;
}

ColourImage colour_sample(Size size, bool is_smooth, std::mt19937& random) {
  const auto made = samples(size, 3, is_smooth, random);
  ColourImage image(size.width, size.height);
  for (std::size_t i = 0; i < image.size(); ++i) image.pixels()[i] = {made[3 * i], made[3 * i + 1], made[3 * i + 2]};
  return image;
}

Image<std::uint16_t> depth_sample(Size size, bool is_smooth, std::mt19937& random) {
  const auto made = samples(size, 2, is_smooth, random);
  Image<std::uint16_t> image(size.width, size.height);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.pixels()[i] =
        static_cast<std::uint16_t>(is_smooth ? 1000 + 10 * made[2 * i] : made[2 * i] << 8 | made[2 * i + 1]);
  }
  return image;
}

std::vector<PngKind> all_png_kinds() {
  std::vector<PngKind> kinds;
  for (const bool is_interlaced : {false, true}) {
    for (const bool has_key : {false, true}) {
      for (const int depth : {1, 2, 4, 8, 16}) kinds.push_back({PNG_COLOR_TYPE_GRAY, depth, is_interlaced, has_key});
      for (const int depth : {1, 2, 4, 8}) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth, is_interlaced, has_key});
      for (const int depth : {8, 16}) kinds.push_back({PNG_COLOR_TYPE_RGB, depth, is_interlaced, has_key});
    }
    for (const int depth : {8, 16}) {
      kinds.push_back({PNG_COLOR_TYPE_GRAY_ALPHA, depth, is_interlaced, false});
      kinds.push_back({PNG_COLOR_TYPE_RGB_ALPHA, depth, is_interlaced, false});
    }
  }
  return kinds;
}

std::string name_of(const PngKind& kind) {
  return "PNG of colour type " + std::to_string(kind.colour_type) + ", " + std::to_string(kind.bit_depth) + " bits" +
         (kind.is_interlaced ? ", interlaced" : "") + (kind.has_colour_key ? ", with a colour key" : "");
}

Bytes png_file(const PngKind& kind, Size size, std::mt19937& random) {
  Bytes bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, append, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(size.width), static_cast<png_uint_32>(size.height), kind.bit_depth,
               kind.colour_type, kind.is_interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (kind.colour_type == PNG_COLOR_TYPE_PALETTE) {
    std::vector<png_color> palette(std::size_t{1} << kind.bit_depth);
    for (png_color& c : palette) {
      c = {static_cast<png_byte>(random()), static_cast<png_byte>(random()), static_cast<png_byte>(random())};
    }
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  }
  if (kind.has_colour_key) add_colour_key(png, info, kind);
  png_write_info(png, info);
  const int row_bytes = static_cast<int>(png_get_rowbytes(png, info));
  auto rows = samples({row_bytes, size.height}, 1, false, random);
  std::vector<png_bytep> starts;
  for (int y = 0; y < size.height; ++y) starts.push_back(rows.data() + std::ptrdiff_t{y} * row_bytes);
  png_write_image(png, starts.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

std::vector<JpegKind> all_jpeg_kinds() {
  std::vector<JpegKind> kinds = {
      {.name = "grey", .components = 1, .in_space = JCS_GRAYSCALE, .file_space = JCS_GRAYSCALE},
      {.name = "4:2:0", .in_space = JCS_RGB, .file_space = JCS_YCbCr},
      {.name = "4:2:2", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .v_sampling = 1},
      {.name = "4:4:0", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .h_sampling = 1},
      {.name = "4:4:4", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .h_sampling = 1, .v_sampling = 1},
      {.name = "4:1:1", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .h_sampling = 4, .v_sampling = 1},
      {.name = "RGB", .in_space = JCS_RGB, .file_space = JCS_RGB, .h_sampling = 1, .v_sampling = 1},
      {.name = "CMYK", .components = 4, .in_space = JCS_CMYK, .file_space = JCS_CMYK, .h_sampling = 1, .v_sampling = 1},
      {.name = "YCCK", .components = 4, .in_space = JCS_CMYK, .file_space = JCS_YCCK},
      {.name = "two components", .components = 2, .in_space = JCS_UNKNOWN, .file_space = JCS_UNKNOWN},
      {.name = "restarts", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .restart_interval = 2},
      {.name = "turned", .in_space = JCS_RGB, .file_space = JCS_YCbCr, .has_orientation = true},
  };
  const std::vector<JpegKind> plain(kinds.begin(), kinds.begin() + 9);
  for (JpegKind kind : plain) {
    kind.name += ", progressive";
    kind.is_progressive = true;
    kinds.push_back(kind);
  }
  for (const std::size_t i : {0u, 1u, 10u, 13u}) {
    JpegKind kind = kinds[i];
    kind.name += ", arithmetic";
    kind.is_arithmetic = true;
    kinds.push_back(kind);
  }
  return kinds;
}

Bytes jpeg_file(const JpegKind& kind, Size size, int quality, bool is_smooth, std::mt19937& random) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long length = 0;
  jpeg_mem_dest(&jpeg, &memory, &length);
  jpeg.image_width = static_cast<JDIMENSION>(size.width);
  jpeg.image_height = static_cast<JDIMENSION>(size.height);
  jpeg.input_components = kind.components;
  jpeg.in_color_space = static_cast<J_COLOR_SPACE>(kind.in_space);
  jpeg_set_defaults(&jpeg);
  jpeg_set_colorspace(&jpeg, static_cast<J_COLOR_SPACE>(kind.file_space));
  jpeg_set_quality(&jpeg, quality, TRUE);
  if (kind.components != 1) {
    jpeg.comp_info[0].h_samp_factor = kind.h_sampling;
    jpeg.comp_info[0].v_samp_factor = kind.v_sampling;
    if (kind.components == 4) {
      jpeg.comp_info[3].h_samp_factor = kind.h_sampling;
      jpeg.comp_info[3].v_samp_factor = kind.v_sampling;
    }
  }
  jpeg.restart_interval = kind.restart_interval;
  if (kind.is_progressive) jpeg_simple_progression(&jpeg);
  jpeg.arith_code = kind.is_arithmetic ? TRUE : FALSE;
  jpeg_start_compress(&jpeg, TRUE);
  if (kind.has_orientation) {
    std::vector<unsigned char> exif = {'E', 'x', 'i', 'f', 0, 0};
    exif.insert(exif.end(), kTurned.begin(), kTurned.end());
    jpeg_write_marker(&jpeg, JPEG_APP0 + 1, exif.data(), static_cast<unsigned>(exif.size()));
  }
  auto pixels = samples(size, kind.components, is_smooth, random);
  for (int y = 0; y < size.height; ++y) {
    JSAMPROW row = pixels.data() + std::ptrdiff_t{y} * size.width * kind.components;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const auto written = std::as_bytes(std::span(memory, length));
  Bytes bytes(written.begin(), written.end());
  std::free(memory);
  return bytes;
}

Bytes without_huffman_tables(const Bytes& jpeg) {
  Bytes bytes(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  const auto copy = [&](std::size_t to) {
    bytes.insert(bytes.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 jpeg.begin() + static_cast<std::ptrdiff_t>(to));
  };
  while (at + 4 <= jpeg.size() && jpeg[at] == std::byte{0xFF}) {
    const auto end = at + 2 + (big_endian_at(jpeg, at) & 0xFFFF);
    if (jpeg[at + 1] != std::byte{0xC4}) copy(end);
    const bool is_scan = jpeg[at + 1] == std::byte{0xDA};
    at = end;
    if (!is_scan) continue;
    std::size_t next = at;  // the end of the scan's entropy-coded bytes: a marker but for those of restarts
    while (jpeg[next] != std::byte{0xFF} || jpeg[next + 1] == std::byte{0} ||
           (jpeg[next + 1] & std::byte{0xF8}) == std::byte{0xD0})
      ++next;
    copy(next);
    at = next;
  }
  copy(jpeg.size());
  return bytes;
}

void repair_crcs(Bytes& png) {
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = big_endian_at(png, at);
    if (length > png.size() - at - 12) return;
    const std::uint32_t crc = crc32(std::span(png).subspan(at + 4, length + 4));
    for (std::size_t i = 0; i < 4; ++i) png[at + 8 + length + i] = static_cast<std::byte>(crc >> (24 - 8 * i) & 0xFF);
    at += length + 12;
  }
}

}  // namespace scanknit::test
