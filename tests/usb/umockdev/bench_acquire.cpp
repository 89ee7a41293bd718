// What acquisition costs: CPU time of its threads, pictures lost, time from the last byte to the frame. With the
// emulated camera, which loses what is not fetched in time: run.sh bench_acquire [SECONDS]
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "acquire/device_source.h"
#include "acquire/steady_now.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

/// Nanoseconds that the threads of acquisition (`usb`, `usb-watch`) have run.
double acquisition_cpu_ns() {
  double sum_ns = 0;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string name;
    std::getline(std::ifstream(thread.path() / "comm"), name);
    double run_ns = 0;
    if (name.starts_with("usb") && std::ifstream(thread.path() / "schedstat") >> run_ns) sum_ns += run_ns;
  }
  return sum_ns;
}

struct Setup {
  const char* name;
  VcamOptions options;
  double fps;
  bool has_colour;
};

void measure(const Setup& setup, double seconds) {
  EmulatedBus bus;
  VcamOptions options = setup.options;
  options.waits_for_computer = false;
  bus.plug(options);
  const auto camera = open_camera("usb:", {}, {});
  if (!camera) return (void)std::printf("%s: %s\n", setup.name, camera.error().text().c_str());
  std::vector<StreamProfile> streams = choose_streams((*camera)->profiles(), options.width, options.height, setup.fps);
  if (!setup.has_colour) streams.resize(1);
  std::atomic<std::int64_t> frames = 0, colour_frames = 0, late_ns = 0, latest_ns = 0;
  const auto started = (*camera)->start(
      streams,
      [&](const RawFrame& frame) {
        const std::int64_t ns = steady_now_ns() - frame.host_ns;
        ++frames;
        if (frame.profile.kind == StreamKind::kColour) ++colour_frames;
        late_ns += ns;
        if (ns > latest_ns) latest_ns = ns;
      },
      [](const DeviceEvent& event) { std::printf("  %s\n", event.text.c_str()); });
  if (!started) return (void)std::printf("%s: %s\n", setup.name, started.error().text().c_str());
  const double cpu_before_ns = acquisition_cpu_ns();
  const std::int64_t before_ns = steady_now_ns(), frames_before = frames;
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const auto elapsed_ns = static_cast<double>(steady_now_ns() - before_ns);
  const double cpu_ns = acquisition_cpu_ns() - cpu_before_ns;
  const auto count = static_cast<double>(frames - frames_before);
  (*camera)->stop();
  std::printf(
      "%-28s %6.1f pictures/s (%lld of them colour)  %3llu lost  %5.2f %% of a core  latency %.3f ms, at most %.3f "
      "ms\n",
      setup.name, count / elapsed_ns * 1e9, static_cast<long long>(colour_frames.load()),
      static_cast<unsigned long long>((*camera)->losses().total()), 100 * cpu_ns / elapsed_ns,
      static_cast<double>(late_ns) / static_cast<double>(frames) / 1e6, static_cast<double>(latest_ns) / 1e6);
}

}  // namespace
}  // namespace scanknit::test

int main(int argc, char** argv) {
  using scanknit::test::Setup;
  const double seconds = argc > 1 ? std::atof(argv[1]) : 5;
  const Setup setups[] = {{"depth 30", {}, 30, false},
                          {"depth and colour 30", {}, 30, true},
                          {"depth and colour 60", {}, 60, true},
                          {"depth and colour 90", {}, 90, true},
                          {"depth 1280x720 30", {.width = 1280, .height = 720}, 30, false},
                          {"depth and colour 1280x720 30", {.width = 1280, .height = 720}, 30, true}};
  for (const Setup& setup : setups) scanknit::test::measure(setup, seconds);
}
