#include "tests/fuzz/play_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  scanknit::play_bytes(bytes, size, [](auto file, const auto& path, const auto& config) {
    return scanknit::index_ros2(std::move(file), path, config);
  });
  return 0;
}
