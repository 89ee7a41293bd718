#include <cstddef>
#include <cstdint>
#include <string_view>

#include "view/view_messages.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  (void)scanknit::parse_client_message({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
