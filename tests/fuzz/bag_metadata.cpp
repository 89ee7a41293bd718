#include <cstddef>
#include <cstdint>
#include <string>

#include "acquire/bag/bag_metadata.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string yaml(bytes, bytes + size);
  if (scanknit::is_bag_metadata(yaml)) (void)scanknit::files_of_bag(yaml);
  return 0;
}
