#include "acquire/raw/raw_recording.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "acquire/raw/raw_decode.h"
#include "acquire/replay/frame_pairing.h"
#include "acquire/stereo/pair_depth.h"

namespace scanknit {
namespace {

Drop unreadable(const Error& error, const FrameEntry& entry) {
  return make_drop(DropReason::kUnreadable, error.message, entry.depth);
}

/// A camera of unknown size fits all.
bool is_of_size(const RawFrame& picture, const CameraModel& camera) {
  const CameraIntrinsics& k = camera.intrinsics;
  return k.width == 0 || (k.width == picture.profile.width && k.height == picture.profile.height);
}

OrDrop<DecodedFrame> decode(const FrameEntry& entry, const Limits& limits, const RawRecording& raw) {
  const auto depth = raw.read(StreamKind::kDepth, entry.depth_index);
  if (!depth) return unreadable(depth.error(), entry);
  std::optional<RawFrame> colour;
  if (!entry.colour.empty() && !raw.colour.empty()) {
    auto read = raw.read(StreamKind::kColour, entry.colour_index);
    if (!read) return unreadable(read.error(), entry);
    colour = *std::move(read);
  }
  auto frame = decode_raw_frame(*depth, colour ? &*colour : nullptr, raw.calibration, limits, raw.pairs.get());
  if (!frame) {
    const bool fits =
        is_of_size(*depth, raw.calibration.depth) && (!colour || is_of_size(*colour, raw.calibration.colour));
    return make_drop(fits ? DropReason::kUnreadable : DropReason::kSizeMismatch, frame.error().message, entry.depth);
  }
  DecodedFrame decoded;
  decoded.depth_m = std::move(frame->depth_m);
  decoded.camera = frame->intrinsics;
  if (!frame->colour) return decoded;
  decoded.colour = std::move(frame->colour->image);
  decoded.encoded_colour = frame->colour->encoded;
  // Without one the source takes depth's, and straightens as it was told.
  if (raw.calibration.colour.intrinsics.width > 0 || !colour) decoded.colour_camera = frame->colour->intrinsics;
  decoded.T_colour_depth = frame->colour->T_colour_depth;
  return decoded;
}

std::vector<std::int64_t> times_of(const std::vector<RawStamp>& stamps) {
  std::vector<std::int64_t> times_ns;
  for (const RawStamp& stamp : stamps) times_ns.push_back(stamp.device_ns);
  return times_ns;
}

std::int64_t reach_ns(const RawRecording& raw) {
  StreamProfile profile;
  if (!raw.colour.empty()) {
    if (const auto first = raw.read(StreamKind::kColour, 0)) profile = first->profile;
  }
  return pairing_reach_ns(profile);
}

}  // namespace

Recording index_raw_recording(RawRecording raw, const AcquireConfig& config) {
  // Straightening what the configuration states is the source's work, as in every layout.
  if (config.intrinsics) raw.calibration.depth = {config.intrinsics->intrinsics, {}};
  if (config.camera && config.camera->colour) raw.calibration.colour = {config.camera->colour->intrinsics, {}};
  if (config.depth_scale) raw.calibration.depth_unit_m = 1 / *config.depth_scale;

  Recording recording{.format = raw.format,
                      .folder = raw.file,
                      .device = raw.calibration.device,
                      .serial = raw.calibration.serial,
                      .depth_scale = 1 / raw.calibration.depth_unit_m};
  recording.frames_bring_camera = raw.calibration.depth.intrinsics.fx != 0;  // its size may be left open
  recording.warnings = std::move(raw.warnings);
  if (raw.pairs) {
    recording.sensor = raw.pairs->sensor();
    recording.has_metric_depth = true;
  }
  const auto is_later = [](const RawStamp& a, const RawStamp& b) { return a.sequence >= b.sequence; };
  const bool is_numbered = std::adjacent_find(raw.depth.begin(), raw.depth.end(), is_later) == raw.depth.end();
  const auto partners = pair_by_time(times_of(raw.depth), times_of(raw.colour), reach_ns(raw));
  const SharedPath file = raw.file;
  for (std::size_t i = 0; i < raw.depth.size(); ++i) {
    FrameEntry entry{.sequence = is_numbered ? raw.depth[i].sequence : i, .timestamp_ns = raw.depth[i].device_ns};
    entry.depth = file;
    entry.depth_index = i;
    if (partners[i]) {
      entry.colour = file;
      entry.colour_index = *partners[i];
    } else if (raw.pairs && raw.colour.empty()) {
      entry.colour = file;  // the left picture
    }
    const auto pose = raw.T_world_camera.find(raw.depth[i].sequence);
    if (pose != raw.T_world_camera.end()) entry.T_world_camera = pose->second;
    recording.entries.push_back(std::move(entry));
  }
  recording.decode = [raw = std::move(raw)](const FrameEntry& entry, const DecodeSettings& settings) {
    return decode(entry, settings.limits, raw);
  };
  return recording;
}

}  // namespace scanknit
