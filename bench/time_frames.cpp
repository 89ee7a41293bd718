// Times the stages of every frame of a recording, all frames in memory before the first: what the pipeline takes when
// nobody decodes pictures on the same processor cores. Prints one JSON object.
//   time_frames RECORDING [--tracked] [--fixed-band] [--voxel-mm N]
#include <fmt/core.h>
#include <malloc.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "acquire/depth_filter.h"
#include "acquire/frame_source.h"
#include "fusion/integrate.h"
#include "fusion/tracker.h"

namespace scanknit {
namespace {

struct Options {
  std::string recording;
  bool is_tracked = false;
  FusionConfig fusion;
};

std::optional<Options> parse(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--tracked") {
      options.is_tracked = true;
    } else if (argument == "--fixed-band") {
      options.fusion.truncation_sigmas = 0;
    } else if (argument == "--voxel-mm" && i + 1 < count) {
      options.fusion.voxel_size_m = std::atof(arguments[++i]) / 1000;
    } else if (options.recording.empty()) {
      options.recording = argument;
    } else {
      return std::nullopt;
    }
  }
  if (options.recording.empty()) return std::nullopt;
  return options;
}

std::optional<std::vector<Frame>> read_frames(const std::string& recording) {
  auto source = open_recording(recording, AcquireConfig{});
  if (!source) {
    fmt::print(stderr, "{}\n", source.error().message);
    return std::nullopt;
  }
  std::vector<Frame> frames;
  for (;;) {
    FrameEvent event = source.value()->next(std::stop_token{});
    if (!std::holds_alternative<Frame>(event)) return frames;
    frames.push_back(std::get<Frame>(std::move(event)));
  }
}

/// Milliseconds by stage, one number a frame.
using Times = std::map<std::string, std::vector<double>>;

class Stopwatch {
 public:
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Nothing when a frame is lost, or has no pose.
std::optional<Times> time_frames(std::vector<Frame> frames, const Options& options) {
  auto volume = TsdfVolume::create(options.fusion);
  if (!volume) return std::nullopt;
  Tracker tracker;
  Times times;
  for (Frame& frame : frames) {
    Stopwatch watch;
    Stopwatch whole;
    filter_frame(frame, AcquireConfig{}, options.fusion.noise);
    times["filter"].push_back(watch.lap_ms());
    std::optional<Pose> pose = frame.T_world_camera;
    if (options.is_tracked) {
      const TrackResult result = tracker.track(frame, *volume);
      const double raycast_ms = std::chrono::duration<double, std::milli>(result.raycast_time).count();
      times["raycast"].push_back(raycast_ms);
      times["track"].push_back(watch.lap_ms() - raycast_ms);
      pose = result.is_lost() ? std::nullopt : std::optional(result.T_world_camera);
    }
    if (!pose || !integrate(frame, *pose, *volume)) return std::nullopt;
    times["integrate"].push_back(watch.lap_ms());
    times["frame"].push_back(whole.lap_ms());
  }
  return times;
}

/// The value that `share` of all are not above.
double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

int run(int count, char** arguments) {
  const auto options = parse(count, arguments);
  if (!options) {
    fmt::print(stderr, "usage: time_frames RECORDING [--tracked] [--fixed-band] [--voxel-mm N]\n");
    return 2;
  }
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 16 << 20);  // as scanknit does: app/main.cpp
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
  auto frames = read_frames(options->recording);
  if (!frames || frames->empty()) return 1;
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 2);
  const auto times = time_frames(std::move(*frames), *options);
  if (!times) {
    fmt::print(stderr, "a frame has no pose\n");
    return 1;
  }
  std::string separator;
  fmt::print("{{");
  for (const auto& [stage, ms] : *times) {
    fmt::print(R"({}"{}": {{"median_ms": {:.2f}, "p95_ms": {:.2f}}})", separator, stage, quantile(ms, 0.5),
               quantile(ms, 0.95));
    separator = ", ";
  }
  fmt::print("}}\n");
  return 0;
}

}  // namespace
}  // namespace scanknit

int main(int count, char** arguments) {
  return scanknit::run(count, arguments);
}
