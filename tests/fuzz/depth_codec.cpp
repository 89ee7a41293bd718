#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "acquire/record/depth_codec.h"
#include "acquire/record/picture_message.h"

// The input as packed depth of as many pixels as it begins with, as a whole picture message, and as depth to be packed:
// that must come back.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto input = std::as_bytes(std::span(bytes, size));
  if (size < 2) return 0;
  const std::size_t pixels = std::size_t{bytes[0]} * 256 + bytes[1];
  (void)scanknit::decode_depth(input.subspan(2), pixels);
  scanknit::Limits limits;
  limits.max_image_bytes = 1u << 20;
  (void)scanknit::unpack_picture(input, limits);
  const auto even = input.first(size / 2 * 2);
  const auto again = scanknit::decode_depth(scanknit::encode_depth(even), even.size() / 2);
  if (!again || !std::equal(again->begin(), again->end(), even.begin(), even.end())) std::abort();
  return 0;
}
