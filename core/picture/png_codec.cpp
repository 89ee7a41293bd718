#include "core/picture/png_codec.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include "core/check.h"

namespace scanknit {
namespace {

static_assert(sizeof(Rgb8) == 3);  // rows of pixels are rows of libpng's samples

// libpng leaves its functions by longjmp. What has a destructor lives in the classes below, outside of the functions
// that call setjmp.

[[noreturn]] void leave(png_structp png, png_const_charp /*message*/) {
  png_longjmp(png, 1);
}

void keep_silent(png_structp /*png*/, png_const_charp /*message*/) {}

/// Notes in the bool that libpng was given that memory is short: libpng itself would call the picture corrupt.
png_voidp get_memory(png_structp png, png_alloc_size_t bytes) {
  void* memory = std::malloc(bytes);
  if (memory == nullptr) *static_cast<bool*>(png_get_mem_ptr(png)) = true;
  return memory;
}

void give_back(png_structp /*png*/, png_voidp memory) {
  std::free(memory);
}

void take_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& left = *static_cast<std::span<const std::byte>*>(png_get_io_ptr(png));
  if (count > left.size()) png_error(png, "truncated");
  std::memcpy(to, left.data(), count);
  left = left.subspan(count);
}

void append_bytes(png_structp png, png_bytep from, std::size_t count) {
  auto& bytes = *static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  bool has_room = true;
  try {
    bytes.insert(bytes.end(), from, from + count);
  } catch (const std::bad_alloc&) {
    has_room = false;
  }
  if (has_room) return;
  *static_cast<bool*>(png_get_mem_ptr(png)) = true;
  png_error(png, "out of memory");
}

void flush_nothing(png_structp /*png*/) {}

void swap_bytes_as_here(png_structp png) {
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);  // of 16 bits; PNG is big-endian
}

enum class Samples { kGrey, kColour, kColourAndAlpha };

class PngReader {
 public:
  explicit PngReader(std::span<const std::byte> bytes)
      : left_(bytes),
        png_(png_create_read_struct_2(PNG_LIBPNG_VER_STRING, nullptr, leave, keep_silent, &lacks_memory_, get_memory,
                                      give_back)) {
    if (png_ == nullptr) return;
    info_ = png_create_info_struct(png_);
    png_set_read_fn(png_, &left_, take_bytes);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// The picture into `rows` of `row_bytes` each; false if the data are corrupt.
  [[nodiscard]] bool read(std::span<png_bytep> rows, std::size_t row_bytes, Samples samples) {
    if (png_ == nullptr || info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_info(png_, info_);
    if (samples == Samples::kGrey) {
      swap_bytes_as_here(png_);
    } else {
      ask_for_colour(samples == Samples::kColourAndAlpha);
    }
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_image_height(png_, info_) != rows.size() || png_get_rowbytes(png_, info_) != row_bytes) return false;
    png_read_image(png_, rows.data());
    png_read_end(png_, info_);
    return true;
  }

  [[nodiscard]] bool lacks_memory() const { return lacks_memory_; }

 private:
  void ask_for_colour(bool with_alpha) {
    png_set_strip_16(png_);
    if (!with_alpha) png_set_strip_alpha(png_);
    const png_byte type = png_get_color_type(png_, info_);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if ((type & PNG_COLOR_MASK_COLOR) == 0) png_set_gray_to_rgb(png_);
  }

  std::span<const std::byte> left_;
  bool lacks_memory_ = false;
  png_structp png_;
  png_infop info_ = nullptr;
};

template <typename T>
Result<Image<T>> decode(const PngFile& file, Samples samples) {
  auto image = Image<T>::uninitialised(file.header.width, file.header.height);
  std::vector<png_bytep> rows;
  rows.reserve(static_cast<std::size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y) rows.push_back(reinterpret_cast<png_bytep>(image.row(y).data()));
  PngReader reader(file.critical);
  if (reader.read(rows, image.row(0).size_bytes(), samples)) return image;
  if (reader.lacks_memory()) throw std::bad_alloc();
  return Error{ErrorCode::kInput, "the picture's compressed data are corrupt"};
}

class PngWriter {
 public:
  PngWriter()
      : png_(png_create_write_struct_2(PNG_LIBPNG_VER_STRING, nullptr, leave, keep_silent, &lacks_memory_, get_memory,
                                       give_back)) {
    if (png_ == nullptr) return;
    info_ = png_create_info_struct(png_);
    png_set_write_fn(png_, &bytes_, append_bytes, flush_nothing);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  template <typename T>
  [[nodiscard]] bool write(const Image<T>& image, PngEffort effort) {
    constexpr bool kIsColour = sizeof(T) == sizeof(Rgb8);
    if (png_ == nullptr || info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    apply(effort);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(image.width()), static_cast<png_uint_32>(image.height()),
                 kIsColour ? 8 : 16, kIsColour ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    swap_bytes_as_here(png_);
    for (int y = 0; y < image.height(); ++y) {
      png_write_row(png_, reinterpret_cast<png_const_bytep>(image.row(y).data()));
    }
    png_write_end(png_, info_);
    return true;
  }

  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }
  [[nodiscard]] bool lacks_memory() const { return lacks_memory_; }

 private:
  /// The files of a recording are compared by their bytes: other settings are other files.
  void apply(PngEffort effort) {
    if (effort == PngEffort::kFast) {
      png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
      png_set_compression_level(png_, Z_BEST_SPEED);
      png_set_compression_strategy(png_, Z_RLE);
    } else {
      png_set_compression_level(png_, effort == PngEffort::kMedium ? 3 : 6);
      png_set_compression_strategy(png_, Z_DEFAULT_STRATEGY);
    }
  }

  std::vector<std::uint8_t> bytes_;
  bool lacks_memory_ = false;
  png_structp png_;
  png_infop info_ = nullptr;
};

template <typename T>
Result<std::vector<std::uint8_t>> encode(const Image<T>& image, PngEffort effort) {
  if (image.empty()) return Error{ErrorCode::kOutput, "a picture without pixels cannot be written"};
  PngWriter writer;
  if (writer.write(image, effort)) return writer.take();
  if (writer.lacks_memory()) throw std::bad_alloc();
  return Error{ErrorCode::kOutput, "the picture could not be encoded as PNG"};
}

}  // namespace

template <typename T>
Result<Image<T>> decode_png_grey(const PngFile& file) {
  SCANKNIT_CHECK(file.header.is_grey && file.header.bit_depth == static_cast<int>(8 * sizeof(T)));
  return decode<T>(file, Samples::kGrey);
}

template Result<Image<std::uint8_t>> decode_png_grey(const PngFile& file);
template Result<Image<std::uint16_t>> decode_png_grey(const PngFile& file);

Result<ColourImage> decode_png_colour(const PngFile& file) {
  return decode<Rgb8>(file, Samples::kColour);
}

Result<Image<std::uint8_t>> decode_png_alpha(const PngFile& file) {
  SCANKNIT_CHECK(file.header.has_alpha);
  const auto pixels = decode<std::array<std::uint8_t, 4>>(file, Samples::kColourAndAlpha);
  if (!pixels) return pixels.error();
  Image<std::uint8_t> alpha(pixels->width(), pixels->height());
  std::transform(pixels->pixels().begin(), pixels->pixels().end(), alpha.pixels().begin(),
                 [](const auto& pixel) { return pixel[3]; });
  return alpha;
}

Result<std::vector<std::uint8_t>> encode_png(const Image<std::uint16_t>& image, PngEffort effort) {
  return encode(image, effort);
}

Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image, PngEffort effort) {
  return encode(image, effort);
}

}  // namespace scanknit
