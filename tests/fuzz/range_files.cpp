// The readers of range scans; the first byte chooses one.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "acquire/range/range_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  scanknit::Limits limits;
  limits.max_image_pixels = 1 << 16;
  switch (bytes[0] % 5) {
    case 0: (void)scanknit::parse_range_ply(text, limits); break;
    case 1: (void)scanknit::parse_ptx(text, limits); break;
    case 2: (void)scanknit::parse_pcd_range(text, limits); break;
    case 3: (void)scanknit::parse_conf(text, limits); break;
    default: (void)scanknit::unpack_gzip(std::string(text), 1 << 20); break;
  }
  return 0;
}
