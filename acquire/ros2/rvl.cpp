#include "acquire/ros2/rvl.h"

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

class Numbers {
 public:
  explicit Numbers(std::span<const std::byte> packed) : words_(packed) {}

  /// Nothing: there is no more, or it has more than 32 bits.
  std::optional<std::uint32_t> next() {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 32; shift += 3) {
      if (groups_ == 0) {
        const auto word = words_.little_endian<std::uint32_t>();
        if (!word) return std::nullopt;
        word_ = *word;
        groups_ = 8;
      }
      const std::uint32_t group = word_ >> 28;
      word_ <<= 4;
      --groups_;
      value |= (group & 7) << shift;
      if ((group & 8) == 0) return value;
    }
    return std::nullopt;
  }

 private:
  ByteReader words_;
  std::uint32_t word_ = 0;
  int groups_ = 0;
};

}  // namespace

std::optional<Image<std::uint16_t>> unpack_rvl(std::span<const std::byte> packed, int width, int height) {
  Image<std::uint16_t> picture(width, height);
  const std::span<std::uint16_t> pixels = picture.pixels();
  Numbers numbers(packed);
  std::uint32_t depth = 0;
  for (std::size_t i = 0; i < pixels.size();) {
    const auto empty = numbers.next();
    const auto full = numbers.next();
    if (!empty || !full || *empty > pixels.size() - i || *full > pixels.size() - i - *empty) return std::nullopt;
    if (*empty == 0 && *full == 0) return std::nullopt;  // no picture has such a run
    i += *empty;
    for (const std::size_t end = i + *full; i < end; ++i) {
      const auto zigzag = numbers.next();
      if (!zigzag) return std::nullopt;
      depth += (*zigzag >> 1) ^ (0u - (*zigzag & 1));
      pixels[i] = static_cast<std::uint16_t>(depth);
    }
  }
  return picture;
}

}  // namespace scanknit
