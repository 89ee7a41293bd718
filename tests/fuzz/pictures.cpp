// Pictures as frames and textures have them.
#include <cstddef>
#include <cstdint>
#include <span>

#include "acquire/replay/picture_codec.h"
#include "core/picture/decode_picture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto file = std::as_bytes(std::span(bytes, size));
  scanknit::Limits limits;
  limits.max_image_pixels = 1 << 16;
  (void)scanknit::decode_picture(file, limits);
  (void)scanknit::decode_depth_png(file, limits);
  (void)scanknit::decode_grey_png(file, limits);
  return 0;
}
