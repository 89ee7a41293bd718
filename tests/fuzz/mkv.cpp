#include "acquire/raw/raw_recording.h"

#include "tests/fuzz/play_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  scanknit::play_bytes(bytes, size, scanknit::index_azure_mkv);
  return 0;
}
