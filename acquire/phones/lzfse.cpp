#include "acquire/phones/lzfse.h"

#include <cstdint>

#include "acquire/phones/lzfse_blocks.h"

namespace scanknit {
namespace {

// The first four bytes of a block, "bvx" and one more, little endian.
enum class LzfseBlock : std::uint32_t {
  kEnd = 0x24787662,    // bvx$
  kPlain = 0x2d787662,  // bvx-
  kFse1 = 0x31787662,   // bvx1
  kFse2 = 0x32787662,   // bvx2
  kLzvn = 0x6e787662,   // bvxn
};

bool copy_plain_block(ByteReader& reader, LzOutput& output) {
  const auto count = reader.little_endian<std::uint32_t>();
  const auto bytes = count ? reader.take(*count) : std::nullopt;
  return bytes && output.begin_block(bytes->size()) && output.append(*bytes);
}

}  // namespace

Result<std::vector<std::byte>> unpack_lzfse(std::span<const std::byte> packed, std::size_t max_bytes) {
  ByteReader reader(packed);
  LzOutput output(max_bytes);
  for (;;) {
    const auto kind = reader.little_endian<std::uint32_t>();
    if (!kind) return Error{ErrorCode::kInput, "the LZFSE stream is truncated"};
    bool is_whole = false;
    switch (static_cast<LzfseBlock>(*kind)) {
      case LzfseBlock::kEnd: return output.take();
      case LzfseBlock::kPlain: is_whole = copy_plain_block(reader, output); break;
      case LzfseBlock::kFse1: is_whole = unpack_fse_block(reader, false, output); break;
      case LzfseBlock::kFse2: is_whole = unpack_fse_block(reader, true, output); break;
      case LzfseBlock::kLzvn: is_whole = unpack_lzvn_block(reader, output); break;
    }
    if (!is_whole) return Error{ErrorCode::kInput, "the LZFSE stream is damaged, truncated, or too large unpacked"};
  }
}

}  // namespace scanknit
