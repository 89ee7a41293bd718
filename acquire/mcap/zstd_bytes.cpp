#include "acquire/mcap/zstd_bytes.h"

#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <memory>
#include <new>

namespace scanknit {
namespace {

constexpr int kLevel = 1;

}  // namespace

std::vector<std::byte> zstd_pack(std::span<const std::byte> bytes) {
  const std::size_t bound = ZSTD_compressBound(bytes.size());
  const auto packed = std::make_unique_for_overwrite<std::byte[]>(bound);
  const std::size_t size = ZSTD_compress(packed.get(), bound, bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the bound is enough; only memory can be short
  return {packed.get(), packed.get() + size};
}

bool is_zstd(std::span<const std::byte> bytes) {
  constexpr std::array kFrame = {std::byte{0x28}, std::byte{0xB5}, std::byte{0x2F},
                                 std::byte{0xFD}};  // RFC 8878, 3.1.1
  return bytes.size() >= kFrame.size() && std::equal(kFrame.begin(), kFrame.end(), bytes.begin());
}

std::optional<std::uint64_t> zstd_content_size(std::span<const std::byte> packed) {
  const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (stated == ZSTD_CONTENTSIZE_ERROR || stated == ZSTD_CONTENTSIZE_UNKNOWN) return std::nullopt;
  return stated;
}

Result<std::vector<std::byte>> zstd_unpack(std::span<const std::byte> packed, std::size_t size) {
  const auto stated = zstd_content_size(packed);
  if (!stated) {
    return Error{ErrorCode::kInput, "the compressed data are truncated or no zstd frame with its size"};
  }
  if (*stated != size) {
    return Error{ErrorCode::kInput,
                 "the compressed data hold " + std::to_string(*stated) + " bytes, expected " + std::to_string(size)};
  }
  std::vector<std::byte> bytes(size);
  const std::size_t unpacked = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_getErrorCode(unpacked) == ZSTD_error_memory_allocation) throw std::bad_alloc();
  if (ZSTD_isError(unpacked) != 0 || unpacked != size) {
    return Error{ErrorCode::kInput, "the compressed data are corrupt"};
  }
  return bytes;
}

}  // namespace scanknit
