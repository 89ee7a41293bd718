#include "synth/sensor/frame_times.h"

#include "core/counter_random.h"

namespace scanknit {

std::vector<FrameTime> frame_times(const RenderedSensor& sensor, int frames, std::uint64_t seed) {
  constexpr std::uint64_t kStream = 0x71'3E5;
  std::vector<FrameTime> times;
  for (std::size_t i = 0; i < static_cast<std::size_t>(frames); ++i) {
    CounterRandom random(seed, kStream, i);
    const double drop = random.uniform();
    const double repeat = random.uniform();
    const double late_s = sensor.colour.delay_s + sensor.colour.jitter_s * random.uniform();
    const FrameTime fresh{i, i, static_cast<double>(i) + late_s * sensor.time.rate_hz};
    if (!times.empty() && drop < sensor.time.dropped) continue;
    const bool is_repeated = !times.empty() && repeat < sensor.time.repeated;
    times.push_back(is_repeated ? FrameTime{i, times.back().taken, times.back().colour_frame} : fresh);
  }
  return times;
}

}  // namespace scanknit
