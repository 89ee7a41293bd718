#include "acquire/phones/lzfse.h"

#include <cstdint>
#include <span>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  constexpr std::size_t kMostBytes = 1u << 20;
  (void)scanknit::unpack_lzfse(std::as_bytes(std::span(bytes, size)), kMostBytes);
  return 0;
}
