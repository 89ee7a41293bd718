// Ten minutes of streaming. Runs with SCANKNIT_LONG_TESTS=1 only.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "acquire/live/live_source.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

using std::chrono::steady_clock;

double resident_mib() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * 4096 / (1 << 20);
}

std::ptrdiff_t open_files() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::distance(begin(all), end(all));
}

constexpr auto kWarmUp = std::chrono::seconds(30);  // pools and arenas fill
// What a busy computer may leave in LiveSource's queue once: 32 pictures. A leak of one a second would be 350 MiB.
constexpr double kGrowth_mib = 32 * 640 * 480 * 2.0 / (1 << 20) + 4;

TEST(Soak, TenMinutesLeaveMemoryAndFilesAsTheyWere) {
  const char* is_wanted = std::getenv("SCANKNIT_LONG_TESTS");
  if (is_wanted == nullptr) GTEST_SKIP() << "SKIPPED: set SCANKNIT_LONG_TESTS=1";
  const char* other_seconds = std::getenv("SCANKNIT_SOAK_SECONDS");
  const std::chrono::seconds duration(other_seconds != nullptr ? std::atoi(other_seconds) : 600);
  EmulatedBus bus;
  bus.plug({});
  auto device = open_camera("usb:", {}, {});
  ASSERT_TRUE(device) << device.error().text();
  LiveScanner scanner;
  scanner.device = *std::move(device);
  scanner.streams = choose_streams(scanner.device->profiles(), 640, 480, 30);
  scanner.calibration = scanner.device->calibration(scanner.streams).value();
  const auto source = LiveSource::start(std::move(scanner), {}, nullptr);
  ASSERT_TRUE(source) << source.error().text();

  const auto begin = steady_clock::now();
  double memory_mib = 0;
  std::ptrdiff_t files = 0;
  std::size_t frames = 0;
  while (steady_clock::now() - begin < duration) {
    if (std::holds_alternative<Frame>((*source)->next({}))) ++frames;
    if (files == 0 && steady_clock::now() - begin > std::min<steady_clock::duration>(kWarmUp, duration / 2)) {
      memory_mib = resident_mib();
      files = open_files();
    }
  }
  const double grown_mib = resident_mib() - memory_mib;
  std::printf("%lld s: %zu frames decoded, %llu pictures lost on the way, memory %.1f MiB %+.1f MiB, files %td %+td\n",
              static_cast<long long>(duration.count()), frames,
              static_cast<unsigned long long>((*source)->losses().total()), memory_mib, grown_mib, files,
              open_files() - files);
  EXPECT_GT(frames, static_cast<std::size_t>(duration.count()) * 5);
  EXPECT_LT(grown_mib, kGrowth_mib);
  EXPECT_EQ(open_files(), files);
  EXPECT_EQ((*source)->losses().transport, 0u);
  EXPECT_FALSE((*source)->failure());
}

}  // namespace
}  // namespace scanknit::test
