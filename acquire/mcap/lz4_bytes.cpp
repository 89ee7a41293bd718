#include "acquire/mcap/lz4_bytes.h"

#include <lz4frame.h>

#include <memory>

namespace scanknit {

Result<std::vector<std::byte>> lz4_unpack(std::span<const std::byte> packed, std::size_t size) {
  const Error corrupt{ErrorCode::kInput, "the LZ4 data are corrupt, or of another size than stated"};
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) return corrupt;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(context,
                                                                                   LZ4F_freeDecompressionContext);
  std::vector<std::byte> bytes(size);
  std::span<std::byte> rest(bytes);
  for (;;) {
    std::size_t read = packed.size();
    std::size_t written = rest.size();
    const std::size_t left = LZ4F_decompress(context, rest.data(), &written, packed.data(), &read, nullptr);
    if (LZ4F_isError(left) != 0) return corrupt;
    packed = packed.subspan(read);
    rest = rest.subspan(written);
    if (left == 0) break;
    if (read == 0 && written == 0) return corrupt;  // truncated, or more than the header promised
  }
  if (!rest.empty()) return corrupt;
  return bytes;
}

}  // namespace scanknit
