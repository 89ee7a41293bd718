#include "acquire/record/depth_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>

#include "acquire/mcap/zstd_bytes.h"

namespace scanknit {
namespace {

// Pixels that are worked on at once: small enough for the first cache.
constexpr std::size_t kBlock = 4096;

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

// v[-1] is the value before the first. No turn of the loop needs another's result, and nothing overlaps: vectorised.
void split(const std::uint16_t* __restrict v, std::size_t count, std::uint8_t* __restrict low,
           std::uint8_t* __restrict high) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t z = zigzag(v[i + 1], v[i]);
    low[i] = static_cast<std::uint8_t>(z);
    high[i] = static_cast<std::uint8_t>(z >> 8);
  }
}

void join(const std::uint8_t* __restrict low, const std::uint8_t* __restrict high, std::size_t count,
          std::uint16_t* __restrict steps) {
  for (std::size_t i = 0; i < count; ++i) steps[i] = unzigzag(static_cast<std::uint16_t>(low[i] | high[i] << 8));
}

}  // namespace

std::vector<std::byte> encode_depth(std::span<const std::byte> z16) {
  SCANKNIT_CHECK(z16.size() % 2 == 0);
  const std::size_t pixels = z16.size() / 2;
  const auto planes = std::make_unique_for_overwrite<std::uint8_t[]>(z16.size());
  std::array<std::uint16_t, 1 + kBlock> values{};  // the one before the block, and the block
  for (std::size_t begin = 0; begin < pixels; begin += kBlock) {
    const std::size_t count = std::min(kBlock, pixels - begin);
    std::memcpy(&values[1], &z16[2 * begin], 2 * count);
    swap_on_big_endian(std::span(values).subspan(1, count));
    split(values.data(), count, &planes[begin], &planes[pixels + begin]);
    values[0] = values[count];
  }
  return zstd_pack(std::as_bytes(std::span(planes.get(), z16.size())));
}

Result<std::vector<std::byte>> decode_depth(std::span<const std::byte> packed, std::size_t pixels) {
  auto unpacked = zstd_unpack(packed, 2 * pixels);
  if (!unpacked) return unpacked.error();
  std::vector<std::byte> z16(2 * pixels);
  std::array<std::uint8_t, kBlock> low{}, high{};
  std::array<std::uint16_t, kBlock> values{};
  std::uint16_t sum = 0;
  for (std::size_t begin = 0; begin < pixels; begin += kBlock) {
    const std::size_t count = std::min(kBlock, pixels - begin);
    std::memcpy(low.data(), &(*unpacked)[begin], count);
    std::memcpy(high.data(), &(*unpacked)[pixels + begin], count);
    join(low.data(), high.data(), count, values.data());
    for (std::size_t i = 0; i < count; ++i) values[i] = sum = static_cast<std::uint16_t>(sum + values[i]);
    swap_on_big_endian(std::span(values).first(count));
    std::memcpy(&z16[2 * begin], values.data(), 2 * count);
  }
  return z16;
}

}  // namespace scanknit
