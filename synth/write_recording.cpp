#include "synth/write_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "core/files/atomic_file.h"
#include "synth/scene/surface_samples.h"
#include "synth/synthetic_source.h"
#include "synth/truth_files.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCameraFile = "camera_intrinsic.json";
constexpr std::array kParts = {"depth", "color", "masks"};

/// Removes pictures with our file names, so that a shorter recording does not end with frames of a longer one.
Result<void> remove_old_pictures(const fs::path& folder) {
  const auto is_ours = [](const fs::path& path) {
    const std::string stem = path.stem().string();
    return stem.size() == 6 && std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; }) &&
           (path.extension() == ".png" || path.extension() == ".jpg");
  };
  std::error_code code;
  std::vector<fs::path> old;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    if (is_ours(entry->path())) old.push_back(entry->path());
  }
  for (std::size_t i = 0; i < old.size() && !code; ++i) fs::remove(old[i], code);
  if (code) return Error{ErrorCode::kOutput, "old frames cannot be removed: " + code.message(), folder.string()};
  return {};
}

Result<void> prepare_folder(const SynthConfig& config, const fs::path& folder) {
  std::error_code code;
  const bool is_foreign = fs::exists(folder / "depth", code) && !fs::exists(folder / kGroundTruthFile, code);
  if (is_foreign) {
    return Error{ErrorCode::kOutput, "holds a recording that is not synthetic; choose another folder", folder.string()};
  }
  for (const char* part : kParts) {
    const bool is_wanted = config.masks || std::string_view(part) != "masks";
    if (!is_wanted && !fs::exists(folder / part, code)) continue;
    fs::create_directories(folder / part, code);
    if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), (folder / part).string()};
    if (auto removed = remove_old_pictures(folder / part); !removed) return removed;
  }
  return {};
}

/// Removes the poses and times of an older recording, because this one may have none.
Result<void> remove_old_poses(const fs::path& folder) {
  std::error_code code;
  for (const char* file : {kPosesFile, kTruePosesFile, kEncoderFile, kTimesFile}) {
    fs::remove(folder / file, code);
    if (code) return Error{ErrorCode::kOutput, "cannot be removed: " + code.message(), (folder / file).string()};
  }
  return {};
}

/// Half a recording looks like a whole one: what was written of one is removed at the end, unless it is kept. The old
/// one in its place went before. Lists no folders: a process that may open no file can do this.
class NewRecording {
 public:
  explicit NewRecording(fs::path folder, bool was_there) : folder_(std::move(folder)), was_there_(was_there) {}
  ~NewRecording() {
    if (is_kept_) return;
    std::error_code ignored;
    for (std::size_t i = 0; i < pictures_; ++i) {
      for (const char* part : kParts) {
        for (const char* ending : {"png", "jpg"}) {
          fs::remove(folder_ / part / fmt::format("{:06}.{}", i, ending), ignored);
        }
      }
    }
    for (const char* file :
         {kPosesFile, kTruePosesFile, kEncoderFile, kTimesFile, kCameraFile, kVisiblePointsFile, kGroundTruthFile}) {
      fs::remove(folder_ / file, ignored);
    }
    for (const char* part : kParts) fs::remove(folder_ / part, ignored);  // if it is empty
    if (!was_there_) fs::remove(folder_, ignored);
  }
  NewRecording(const NewRecording&) = delete;
  NewRecording& operator=(const NewRecording&) = delete;

  void begin_picture() { ++pictures_; }
  void keep() { is_kept_ = true; }

 private:
  fs::path folder_;
  bool was_there_, is_kept_ = false;
  std::size_t pictures_ = 0;
};

/// One line for each frame, in degrees.
std::string encoder_text(const TurntableRig& rig, const std::vector<FrameTime>& times, std::size_t frames) {
  std::string text;
  for (std::size_t i = 0; i < frames; ++i) {
    text += fmt::format("{:.6f}\n", rig.steady_angle_rad(times[i].stamp) * 180 / std::numbers::pi);
  }
  return text;
}

/// One line for each picture, in seconds.
std::string times_text(const SyntheticScanner& scanner, std::size_t pictures) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  std::string text;
  for (std::size_t i = 0; i < pictures; ++i) {
    const std::int64_t time_ns = scanner.timestamp_ns(i);
    text += fmt::format("{}.{:09}\n", time_ns / kSecond_ns, time_ns % kSecond_ns);
  }
  return text;
}

Result<void> write_poses(const SyntheticScanner& scanner, const SynthConfig& config, std::size_t pictures,
                         const std::string& trajectory, const fs::path& folder) {
  if (config.sensor) {
    if (auto done = write_file_atomically(folder / kTimesFile, times_text(scanner, pictures)); !done) return done;
  }
  const TurntableRig* rig = scanner.turntable();
  if (rig == nullptr) return write_file_atomically(folder / kPosesFile, trajectory);
  if (auto done = write_file_atomically(folder / kTruePosesFile, trajectory); !done) return done;
  const std::size_t frames = pictures / static_cast<std::size_t>(config.stills);
  return write_file_atomically(folder / kEncoderFile, encoder_text(*rig, scanner.times(), frames));
}

/// White where there is a surface.
ColourImage mask_of(const DepthImage& depth_m) {
  ColourImage mask(depth_m.width(), depth_m.height());
  std::transform(depth_m.pixels().begin(), depth_m.pixels().end(), mask.pixels().begin(), [](float depth) {
    return depth > 0 ? Rgb8{255, 255, 255} : Rgb8{};
  });
  return mask;
}

Result<void> write_shot(const Shot& shot, std::size_t number, const SynthConfig& config, const fs::path& folder) {
  const fs::path depth_path = folder / "depth" / fmt::format("{:06}.png", number);
  if (auto done = write_depth_png(to_raw_depth(shot.depth_m, units_per_metre(config)), depth_path); !done) return done;
  if (config.masks) {
    const fs::path mask_path = folder / "masks" / fmt::format("{:06}.png", number);
    if (auto done = write_colour_png(mask_of(shot.exact.depth_m), mask_path); !done) return done;
  }
  const fs::path colour_path = folder / "color" / fmt::format("{:06}.{}", number, config.jpeg_colour ? "jpg" : "png");
  return config.jpeg_colour ? write_colour_jpeg(shot.colour, colour_path) : write_colour_png(shot.colour, colour_path);
}

}  // namespace

Result<SynthSummary> write_synthetic_recording(const SyntheticScene& scene, const SynthConfig& config,
                                               const fs::path& folder, const SynthProgress& progress,
                                               std::stop_token stop) {
  if (auto valid = validate(config); !valid) return valid.error();
  std::error_code ignored;
  const bool was_there = fs::exists(folder, ignored);
  if (auto ready = prepare_folder(config, folder); !ready) return ready.error();
  NewRecording recording(folder, was_there);
  // Written first as well as last: it marks the folder as ours even if the run is killed.
  if (auto marked = write_truth(scene, config, 0, {}, folder); !marked) return marked.error();
  const fs::path camera_file = folder / kCameraFile;
  if (auto done = write_camera_json(stated_camera(config), units_per_metre(config), camera_file); !done) {
    return done.error();
  }

  const SyntheticScanner scanner(scene, config);
  if (auto removed = remove_old_poses(folder); !removed) return removed.error();
  std::vector<TruthPoint> points = sample_surface(scene, config.truth_points, config.seed);
  SynthSummary summary;
  summary.truth_points = points.size();
  std::string trajectory;
  for (; summary.frames < scanner.pictures(); ++summary.frames) {
    if (stop.stop_requested()) {
      summary.was_stopped = true;
      break;
    }
    recording.begin_picture();
    const Shot shot = scanner.shoot(summary.frames);
    count_views(shot.exact, shot.camera, points);
    append_log_pose(trajectory, summary.frames, shot.T_world_camera.matrix());
    if (auto done = write_shot(shot, summary.frames, config, folder); !done) return done.error();
    if (progress) progress(summary.frames + 1, scanner.pictures());
  }
  std::erase_if(points,
                [&](const TruthPoint& point) { return point.views < static_cast<std::uint32_t>(config.min_views); });
  summary.visible_points = points.size();
  if (auto done = write_poses(scanner, config, summary.frames, trajectory, folder); !done) return done.error();
  if (auto done = write_truth(scene, config, summary.frames, points, folder); !done) return done.error();
  recording.keep();
  return summary;
}

}  // namespace scanknit
