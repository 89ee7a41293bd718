// Times the stages of every frame of a recording, all frames in memory before the first: what the pipeline takes when
// nobody decodes pictures on the same processor cores. Prints one JSON object a line, for each part of the recording.
//   time_frames RECORDING [--tracked] [--fixed-band] [--voxel-mm N] [--parts N [--afresh]]
// --afresh: each part begins with an empty volume, so that what a scan's growth costs is seen.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "acquire/frame_source.h"
#include "core/files/ascii_numbers.h"
#include "core/system/freed_memory.h"
#include "fusion/integrate/integrate.h"
#include "fusion/track/tracker.h"

namespace scanknit {
namespace {

struct Options {
  std::string recording;
  bool is_tracked = false;
  int parts = 1;
  bool begins_afresh = false;  ///< with each part
  FusionConfig fusion;
};

std::optional<Options> parse(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--tracked") {
      options.is_tracked = true;
    } else if (argument == "--afresh") {
      options.begins_afresh = true;
    } else if (argument == "--parts" && i + 1 < count) {
      const auto parts = parse_integer(arguments[++i]);
      if (!parts || *parts < 1) return std::nullopt;
      options.parts = static_cast<int>(*parts);
    } else if (argument == "--fixed-band") {
      options.fusion.truncation_sigmas = 0;
    } else if (argument == "--voxel-mm" && i + 1 < count) {
      const auto voxel_mm = parse_double(arguments[++i]);
      if (!voxel_mm) return std::nullopt;
      options.fusion.voxel_size_m = *voxel_mm / 1000;
    } else if (options.recording.empty()) {
      options.recording = argument;
    } else {
      return std::nullopt;
    }
  }
  if (options.recording.empty()) return std::nullopt;
  return options;
}

/// At least one; without those that are dropped.
Result<std::vector<Frame>> read_frames(const std::string& recording) {
  auto source = open_recording(recording, AcquireConfig{});
  if (!source) return source.error();
  std::vector<Frame> frames;
  for (;;) {
    FrameEvent event = (*source)->next(std::stop_token{});
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (auto* error = std::get_if<Error>(&event)) return *std::move(error);
    if (auto* frame = std::get_if<Frame>(&event)) frames.push_back(std::move(*frame));
  }
  if (frames.empty()) return Error{ErrorCode::kInput, "no usable frame", recording};
  return frames;
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

/// Errors: those of integration, a frame that is lost or has no pose.
Result<Times> time_frames(std::span<const Frame> frames, const Options& options, TsdfVolume& volume, Tracker& tracker) {
  Times times;
  for (Frame frame : frames) {  // a copy, whose memory the next one has again, as in a scan
    Stopwatch watch;
    Stopwatch whole;
    if (auto filtered = filter_frame(frame, AcquireConfig{}, options.fusion.noise); !filtered) return filtered.error();
    times["filter"].push_back(watch.lap_ms());
    const auto fault = [&](const std::string& text) {
      return Error{ErrorCode::kTooLittle, fmt::format("frame {}: {}", frame.sequence, text), options.recording};
    };
    std::optional<Pose> pose = frame.T_world_camera;
    if (options.is_tracked) {
      const TrackResult result = tracker.track(frame, volume);
      const double raycast_ms = std::chrono::duration<double, std::milli>(result.raycast_time).count();
      times["raycast"].push_back(raycast_ms);
      times["track"].push_back(watch.lap_ms() - raycast_ms);
      if (result.is_lost()) return fault(std::string("lost: ") + to_string(result.reason));
      pose = result.T_world_camera;
    }
    if (!pose) return fault("has no pose; --tracked finds one");
    if (const auto integrated = integrate(frame, *pose, volume); !integrated) return fault(integrated.error().text());
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

void print(const Times& times) {
  std::string separator;
  fmt::print("{{");
  for (const auto& [stage, ms] : times) {
    fmt::print(R"({}"{}": {{"median_ms": {:.2f}, "p95_ms": {:.2f}}})", separator, stage, quantile(ms, 0.5),
               quantile(ms, 0.95));
    separator = ", ";
  }
  fmt::print("}}\n");
}

int fail(const Error& error) {
  fmt::print(stderr, "{}\n", error.text());
  return 1;
}

int run(int count, char** arguments) {
  const auto options = parse(count, arguments);
  if (!options) {
    fmt::print(stderr,
               "usage: time_frames RECORDING [--tracked] [--fixed-band] [--voxel-mm N] [--parts N [--afresh]]\n");
    return 2;
  }
  keep_freed_memory();  // as scanknit does
  auto frames = read_frames(options->recording);
  if (!frames) return fail(frames.error());
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 2);
  std::optional<TsdfVolume> volume;
  std::optional<Tracker> tracker;
  const std::size_t parts = std::min(static_cast<std::size_t>(options->parts), frames->size());
  for (std::size_t part = 0; part < parts; ++part) {
    if (part == 0 || options->begins_afresh) {
      auto created = TsdfVolume::create(options->fusion);
      if (!created) return fail(created.error());
      volume = *std::move(created);
      tracker.emplace();
    }
    const std::size_t first = part * frames->size() / parts;
    const std::size_t end = (part + 1) * frames->size() / parts;
    const auto times = time_frames(std::span(*frames).subspan(first, end - first), *options, *volume, *tracker);
    if (!times) return fail(times.error());
    print(*times);
  }
  return 0;
}

}  // namespace
}  // namespace scanknit

int main(int count, char** arguments) {
  return scanknit::run(count, arguments);
}
