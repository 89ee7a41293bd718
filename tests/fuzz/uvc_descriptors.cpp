#include <cstddef>
#include <cstdint>
#include <span>

#include "acquire/uvc/uvc_descriptors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  (void)scanknit::parse_uvc_configuration(std::as_bytes(std::span(bytes, size)));
  return 0;
}
