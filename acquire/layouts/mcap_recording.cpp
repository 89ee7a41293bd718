// Recordings of our own (acquire/record/recorder.h).
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/mcap/append_file.h"
#include "acquire/mcap/mcap_reader.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/record/picture_message.h"
#include "acquire/record/recording_channels.h"
#include "acquire/sensor/scanner_camera.h"
#include "acquire/stereo/pair_depth.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

constexpr std::uint64_t kMaxTextBytes = 1u << 20;  // of a calibration or a pose

struct McapRecording {
  McapReader reader;
  std::vector<McapMessagePlace> depth = {}, colour = {};
  Limits limits = {};
};

Result<RawFrame> read_picture(McapRecording& file, StreamKind kind, std::size_t index) {
  const McapMessagePlace& place = (kind == StreamKind::kDepth ? file.depth : file.colour)[index];
  const auto message = file.reader.read(place);
  if (!message) return message.error();
  auto frame = unpack_picture(*message, file.limits);
  if (!frame) return frame;
  if (frame->profile.kind != kind) return Error{ErrorCode::kInput, "the picture is in the other stream's channel"};
  frame->host_ns = static_cast<std::int64_t>(place.log_ns);
  frame->device_ns = static_cast<std::int64_t>(place.publish_ns);
  return frame;
}

std::vector<RawStamp> stamps_of(const std::vector<McapMessagePlace>& places) {
  std::vector<RawStamp> stamps;
  for (const McapMessagePlace& place : places) {
    stamps.push_back({place.sequence, static_cast<std::int64_t>(place.publish_ns)});
  }
  return stamps;
}

// Sorts the messages by channel; the first calibration that can be read is taken.
void sort_messages(McapRecording& file, RawRecording& raw) {
  std::optional<RawCalibration> calibration;
  const std::deque<McapMessagePlace>& places = file.reader.messages();
  const auto is_of = [&](const McapMessagePlace& place, const char* topic) {
    const McapChannel* channel = file.reader.find_channel(topic);
    return channel != nullptr && channel->id == place.channel;
  };
  for (const McapMessagePlace& place : places) {
    if (is_of(place, kDepthTopic)) {
      file.depth.push_back(place);
    } else if (is_of(place, kColourTopic)) {
      file.colour.push_back(place);
    } else if (place.length <= kMaxTextBytes && is_of(place, kPoseTopic)) {
      const auto message = file.reader.read(place);
      const auto pose = message ? parse_pose(*message) : std::nullopt;
      if (pose) raw.T_world_camera.insert_or_assign(place.sequence, pose->T_world_camera);
    } else if (place.length <= kMaxTextBytes && !calibration && is_of(place, kCalibrationTopic)) {
      const auto message = file.reader.read(place);
      const auto parsed = message ? parse_calibration(*message) : message.error();
      if (parsed) calibration = *parsed;
    }
  }
  if (calibration) raw.calibration = *std::move(calibration);
}

/// What the depth pictures are: the first that can be read says it.
PixelFormat depth_format_of(McapRecording& file) {
  constexpr std::size_t kMostTries = 16;
  for (std::size_t i = 0; i < std::min(file.depth.size(), kMostTries); ++i) {
    if (const auto picture = read_picture(file, StreamKind::kDepth, i)) return picture->profile.format;
  }
  return PixelFormat::kZ16;
}

/// Pairs become depth whatever acquire.geometry says: there is no other use of them.
Result<void> take_pairs(RawRecording& raw, const AcquireConfig& config) {
  if (const auto allowed = refuse_other_cameras(config, raw.file.string()); !allowed) return allowed;
  auto pairs = PairDepth::create(raw.calibration, config.min_depth_m);
  if (!pairs) return Error{ErrorCode::kInput, pairs.error().message, raw.file.string()};
  raw.pairs = *std::move(pairs);
  return {};
}

}  // namespace

bool fits_mcap(const RandomAccess& file) {
  return is_mcap(file);
}

Result<Recording> index_mcap(std::unique_ptr<RandomAccess> access, const std::filesystem::path& path,
                             const AcquireConfig& config) {
  auto reader = McapReader::open(std::move(access), config.limits);
  if (!reader) return located(reader.error(), path);
  if (reader->find_channel(kDepthTopic) == nullptr) {
    // Not every writer of ROS 2's messages states their profile.
    const auto& channels = reader->channels();
    const bool is_of_ros2 = std::any_of(channels.begin(), channels.end(),
                                        [](const McapChannel& channel) { return channel.message_encoding == "cdr"; });
    if (is_of_ros2) return index_bag(messages_of_mcap(*std::move(reader), config.limits), path, config);
    return Error{ErrorCode::kInput,
                 std::string("an MCAP file, but not a recording of ours: it has no channel ") + kDepthTopic,
                 path.string()};
  }
  const auto file = std::make_shared<McapRecording>(McapRecording{*std::move(reader), {}, {}, config.limits});
  RawRecording raw{.format = "mcap", .file = path};
  sort_messages(*file, raw);
  if (depth_format_of(*file) == PixelFormat::kY8i) {
    if (const auto taken = take_pairs(raw, config); !taken) return taken.error();
  } else if (config.geometry == Geometry::kStereo) {
    return Error{ErrorCode::kInput, "it holds depth, and no pairs of pictures: leave acquire.geometry at depth",
                 path.string()};
  }
  raw.depth = stamps_of(file->depth);
  raw.colour = stamps_of(file->colour);
  if (const auto& fault = file->reader.fault()) {
    raw.warnings.push_back(is_being_appended(path) ? "it is still being recorded: what is in it so far is read"
                                                   : "the recording is torn: " + *fault +
                                                         ". What came before is read; `scanknit repair` mends it");
  }
  raw.read = [file](StreamKind kind, std::size_t index) { return read_picture(*file, kind, index); };
  return index_raw_recording(std::move(raw), config);
}

}  // namespace scanknit
