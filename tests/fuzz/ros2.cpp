#include "acquire/bag/bag_messages.h"
#include "acquire/lidar/bag_sweeps.h"
#include "tests/fuzz/play_bytes.h"

namespace scanknit {
namespace {

/// The same bag as LiDAR sweeps, and then as a recording of depth pictures.
Result<Recording> play_both(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                            const AcquireConfig& config, std::span<const std::byte> bytes) {
  if (auto messages = open_bag_file(std::make_unique<MemoryAccess>(bytes), path, config.limits)) {
    const auto sweeps = index_bag_sweeps({*std::move(messages)}, path, config);
    for (std::size_t i = 0; sweeps && i < (*sweeps)->info().sweeps; ++i) (void)(*sweeps)->read(i);
  }
  return index_ros2(std::move(file), path, config);
}

}  // namespace
}  // namespace scanknit

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  scanknit::play_bytes(bytes, size, [&](auto file, const auto& path, const auto& config) {
    return scanknit::play_both(std::move(file), path, config, std::as_bytes(std::span(bytes, size)));
  });
  return 0;
}
