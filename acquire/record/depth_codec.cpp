#include "acquire/record/depth_codec.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "acquire/record/zstd_bytes.h"

namespace scanknit {
namespace {

std::uint16_t swap_bytes(std::uint16_t v) {
  return static_cast<std::uint16_t>(v << 8 | v >> 8);
}

// Between the bytes of a file, little endian, and numbers of this machine.
void swap_on_big_endian([[maybe_unused]] std::span<std::uint16_t> values) {
  if constexpr (std::endian::native == std::endian::big) {
    for (std::uint16_t& value : values) value = swap_bytes(value);
  }
}

std::uint16_t zigzag(std::uint16_t value, std::uint16_t before) {
  const auto difference = static_cast<std::uint16_t>(value - before);
  const auto sign = static_cast<std::uint16_t>(-(difference >> 15));  // all ones when negative
  return static_cast<std::uint16_t>(difference << 1 ^ sign);
}

std::uint16_t unzigzag(std::uint16_t z) {
  return static_cast<std::uint16_t>(z >> 1 ^ -(z & 1));
}

}  // namespace

std::vector<std::byte> encode_depth(std::span<const std::byte> z16) {
  SCANKNIT_CHECK(z16.size() % 2 == 0);
  const std::size_t pixels = z16.size() / 2;
  if (pixels == 0) return zstd_pack({});
  std::vector<std::uint16_t> values(pixels);
  std::memcpy(values.data(), z16.data(), z16.size());
  swap_on_big_endian(values);

  std::vector<std::byte> planes(z16.size());
  const std::uint16_t* v = values.data();
  std::byte* low = planes.data();
  std::byte* high = low + pixels;
  const std::uint16_t first = zigzag(v[0], 0);
  low[0] = static_cast<std::byte>(first & 0xFF);
  high[0] = static_cast<std::byte>(first >> 8);
  for (std::size_t i = 1; i < pixels; ++i) {  // no iteration needs another's result: vectorised
    const std::uint16_t z = zigzag(v[i], v[i - 1]);
    low[i] = static_cast<std::byte>(z & 0xFF);
    high[i] = static_cast<std::byte>(z >> 8);
  }
  return zstd_pack(planes);
}

Result<std::vector<std::byte>> decode_depth(std::span<const std::byte> packed, std::size_t pixels) {
  const auto planes = zstd_unpack(packed, 2 * pixels);
  if (!planes) return planes.error();
  if (pixels == 0) return std::vector<std::byte>();
  std::vector<std::uint16_t> values(pixels);
  const std::byte* low = planes->data();
  const std::byte* high = low + pixels;
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto z =
        static_cast<std::uint16_t>(std::to_integer<unsigned>(low[i]) | std::to_integer<unsigned>(high[i]) << 8);
    values[i] = unzigzag(z);
  }
  std::uint16_t sum = 0;
  for (std::uint16_t& value : values) {
    sum = static_cast<std::uint16_t>(sum + value);
    value = sum;
  }
  swap_on_big_endian(values);
  std::vector<std::byte> z16(2 * pixels);
  std::memcpy(z16.data(), values.data(), z16.size());
  return z16;
}

}  // namespace scanknit
