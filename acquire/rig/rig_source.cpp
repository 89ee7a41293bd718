#include "acquire/rig/rig_source.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/replay/indexed_source.h"

namespace scanknit {
namespace {

/// A camera whose recording can be read.
struct OpenedCamera {
  std::unique_ptr<IndexedSource> source;
  Pose T_rig_camera = Pose::Identity();
  std::int64_t clock_offset_ns = 0;
};

struct RigFrame {
  std::int64_t time_ns = 0;  ///< by the rig's clock; without one, the frame's number in its recording
  std::size_t camera = 0, index = 0;
};

/// Times that would leave 64 bits stay at their end.
std::int64_t later_by(std::int64_t time_ns, std::int64_t offset_ns) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(time_ns, offset_ns, &sum)) return sum;
  return offset_ns > 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

/// All frames in their order. A frame whose time is not known comes after the one before it.
std::vector<RigFrame> in_order(const std::vector<OpenedCamera>& cameras, bool has_clock) {
  std::vector<RigFrame> frames;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const IndexedSource& source = *cameras[camera].source;
    std::int64_t time_ns = std::numeric_limits<std::int64_t>::min();
    for (std::size_t index = 0; index < source.info().frames; ++index) {
      if (!has_clock) time_ns = static_cast<std::int64_t>(index);
      const auto stamp = has_clock ? source.time_of(index) : std::nullopt;
      if (stamp) time_ns = later_by(*stamp, cameras[camera].clock_offset_ns);
      frames.push_back({time_ns, camera, index});
    }
  }
  std::ranges::stable_sort(frames, {}, &RigFrame::time_ns);  // of one time: in the order of the cameras
  return frames;
}

/// The times of frames in order, made to ascend strictly: pictures of one trigger have one time.
void make_ascend(std::vector<RigFrame>& frames) {
  constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const std::int64_t before = frames[i - 1].time_ns;
    if (frames[i].time_ns <= before && before < kLatest) frames[i].time_ns = before + 1;
  }
}

class RigSource final : public FrameSource {
 public:
  RigSource(std::vector<OpenedCamera> cameras, const AcquireConfig& config, std::vector<std::string> warnings)
      : cameras_(std::move(cameras)), every_(config.every), next_(config.from) {
    has_clock_ = std::ranges::all_of(cameras_, [](const auto& camera) { return camera.source->has_clock(); });
    frames_ = in_order(cameras_, has_clock_);
    make_ascend(frames_);
    end_ = config.to < frames_.size() ? config.to + 1 : frames_.size();
    describe(std::move(warnings));
  }

  [[nodiscard]] const RecordingInfo& info() const override { return info_; }

  [[nodiscard]] FrameEvent next(std::stop_token stop) override {
    if (stop.stop_requested() || next_ >= end_) return EndOfStream{};
    const std::size_t place = next_;
    next_ = every_ < end_ - place ? place + every_ : end_;
    const RigFrame& asked = frames_[place];
    FrameEvent event = cameras_[asked.camera].source->frame(asked.index);
    if (auto* dropped = std::get_if<FrameDropped>(&event)) dropped->sequence = place;
    if (auto* frame = std::get_if<Frame>(&event)) {
      frame->sequence = place;
      frame->has_clock = has_clock_;
      frame->timestamp_ns = has_clock_ ? asked.time_ns : static_cast<std::int64_t>(place);
      frame->T_world_camera = cameras_[asked.camera].T_rig_camera;
    }
    return event;
  }

 private:
  void describe(std::vector<std::string> warnings) {
    info_ = cameras_.front().source->info();
    info_.format = "rig";
    info_.frames = info_.frames_with_pose = frames_.size();
    info_.poses = PoseMode::kRecording;
    info_.world_up = UpAxis::kMinusY;  // the world is the first camera's frame
    info_.topics.clear();
    info_.duration_s.reset();
    if (has_clock_) {
      info_.duration_s =
          (static_cast<double>(frames_.back().time_ns) - static_cast<double>(frames_.front().time_ns)) * 1e-9;
    }
    info_.warnings = std::move(warnings);
    for (const OpenedCamera& camera : cameras_) {
      const RecordingInfo& own = camera.source->info();
      info_.has_colour |= own.has_colour;
      if (!info_.colour_intrinsics) info_.colour_intrinsics = own.colour_intrinsics;
      for (const std::string& warning : own.warnings) info_.warnings.push_back(own.folder.string() + ": " + warning);
    }
  }

  std::vector<OpenedCamera> cameras_;
  bool has_clock_ = false;
  std::vector<RigFrame> frames_;
  std::size_t every_, next_, end_ = 0;
  RecordingInfo info_;
};

/// What is asked of each recording: all of its frames, at the origin.
AcquireConfig config_of(const RigCamera& camera, AcquireConfig config) {
  config.from = 0;
  config.to = std::numeric_limits<std::size_t>::max();
  config.every = 1;
  config.poses = PoseMode::kStill;
  if (camera.camera) config.camera = camera.camera;
  return config;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_rig(const Rig& rig, const AcquireConfig& config) {
  if (is_tracked(config.poses)) {
    return Error{ErrorCode::kConfig, "acquire.poses: the poses of a rig's cameras are known, expected auto"};
  }
  if (config.every == 0 || config.from > config.to) {
    return Error{ErrorCode::kConfig, "expected every of 1 or more, and from no more than to"};
  }
  std::vector<OpenedCamera> opened;
  std::vector<std::string> warnings;
  std::optional<Error> first_fault;
  for (const RigCamera& camera : rig.cameras) {
    auto source = open_indexed(camera.recording, config_of(camera, config));
    if (source) {
      opened.push_back({*std::move(source), camera.T_rig_camera, camera.clock_offset_ns});
      continue;
    }
    if (source.error().code == ErrorCode::kConfig) return source.error();
    if (!first_fault) first_fault = source.error();
    warnings.push_back("a camera of the rig is left out: " + source.error().text());
  }
  if (opened.empty()) return first_fault.value_or(Error{ErrorCode::kInput, "the rig has no camera"});
  std::size_t frames = 0;
  for (const OpenedCamera& camera : opened) frames += camera.source->info().frames;
  if (config.from >= frames) {
    return Error{ErrorCode::kInput, "from " + std::to_string(config.from) + " selects no frame: the recordings have " +
                                        std::to_string(frames) + ", counted from 0"};
  }
  if (frames > config.limits.max_frames) {
    return Error{ErrorCode::kInput, "more frames than " + std::to_string(config.limits.max_frames)};
  }
  return std::unique_ptr<FrameSource>(std::make_unique<RigSource>(std::move(opened), config, std::move(warnings)));
}

}  // namespace scanknit
