#include "acquire/raw/raw_recording.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "acquire/mkv/azure_calibration.h"
#include "acquire/mkv/mkv_file.h"
#include "acquire/raw/raw_decode.h"
#include "acquire/raw_frame.h"
#include "acquire/replay/frame_pairing.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostPictureSide = 1u << 16;
constexpr const char* kStateCamera =
    "; give the camera as acquire.intrinsics=[504,504,320,288] (fx, fy, cx, cy of depth in pixels)";

/// How a colour track's pictures are packed.
enum class AzureColour { kMjpeg, kYuy2, kNv12, kBgra };

std::optional<AzureColour> colour_of(const MkvTrack& track) {
  if (track.fourcc == "MJPG" || track.codec == "V_MJPEG") return AzureColour::kMjpeg;
  if (track.fourcc == "YUY2") return AzureColour::kYuy2;
  if (track.fourcc == "NV12") return AzureColour::kNv12;
  if (track.fourcc == "BGRA") return AzureColour::kBgra;
  return std::nullopt;
}

/// A text of the file for a message: short, and without what a terminal would obey.
std::string shown(const std::string& text) {
  constexpr std::size_t kMostLetters = 40;
  std::string letters = text.substr(0, kMostLetters);
  for (char& letter : letters) letter = letter >= ' ' && letter <= '~' ? letter : '?';
  return letters;
}

std::string coding_of(const MkvTrack& track) {
  return shown(track.fourcc.empty() ? track.codec : track.fourcc);
}

struct AzureLens {
  CameraIntrinsics camera;
  RationalDistortion distortion{};
};

/// All that is needed to read a frame.
struct AzureRecording {
  std::unique_ptr<RandomAccess> file;
  MkvTrack depth_track, colour_track;
  AzureColour colour_coding = AzureColour::kMjpeg;
  std::vector<MkvBlock> depth, colour;
  std::optional<AzureLens> depth_lens = {};  ///< nothing: the configuration states the camera
  AzureLens colour_lens = {};
  Pose T_colour_depth = Pose::Identity();

  [[nodiscard]] Result<std::vector<std::byte>> read(const MkvBlock& block, const Limits& limits) const {
    if (block.bytes > limits.max_image_bytes) return Error{ErrorCode::kInput, "a picture has too many bytes"};
    std::vector<std::byte> bytes(static_cast<std::size_t>(block.bytes));
    if (!file->read(block.at, bytes)) {
      return Error{ErrorCode::kInput, "a picture cannot be read; did the file change?"};
    }
    return bytes;
  }
};

/// Y of all pixels, then U V of each 2 x 2 of them: as Y0 U Y1 V of two rows each, which loses nothing.
std::vector<std::byte> yuyv_from_nv12(const std::vector<std::byte>& bytes, std::size_t width, std::size_t height) {
  std::vector<std::byte> packed(2 * width * height);
  const std::size_t chroma = width * height;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      packed[2 * (y * width + x)] = bytes[y * width + x];
      packed[2 * (y * width + x) + 1] = bytes[chroma + y / 2 * width + x];
    }
  }
  return packed;
}

std::vector<std::byte> bgr_from_bgra(const std::vector<std::byte>& bytes) {
  std::vector<std::byte> packed;
  packed.reserve(bytes.size() / 4 * 3);
  for (std::size_t i = 0; i + 3 < bytes.size(); i += 4) {
    packed.insert(packed.end(), {bytes[i], bytes[i + 1], bytes[i + 2]});
  }
  return packed;
}

RawFrame raw_frame(StreamKind kind, PixelFormat format, const MkvTrack& track, std::size_t index,
                   std::vector<std::byte> bytes) {
  RawFrame raw;
  raw.profile = {kind, format, static_cast<int>(track.width), static_cast<int>(track.height)};
  raw.sequence = index;
  raw.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  return raw;
}

Result<DepthImage> decode_depth(const AzureRecording& recording, std::size_t index, const DecodeSettings& settings) {
  auto bytes = recording.read(recording.depth.at(index), settings.limits);
  if (!bytes) return bytes.error();
  for (std::size_t i = 0; i + 1 < bytes->size(); i += 2) std::swap((*bytes)[i], (*bytes)[i + 1]);  // b16g: big endian
  return decode_raw_depth(
      raw_frame(StreamKind::kDepth, PixelFormat::kZ16, recording.depth_track, index, *std::move(bytes)),
      1 / settings.depth_scale, settings.limits);
}

/// As a kind of picture that live cameras deliver, too.
Result<RawFrame> raw_colour(const AzureRecording& recording, std::size_t index, const Limits& limits) {
  auto bytes = recording.read(recording.colour.at(index), limits);
  if (!bytes) return bytes.error();
  const MkvTrack& track = recording.colour_track;
  const auto width = static_cast<std::size_t>(track.width), height = static_cast<std::size_t>(track.height);
  PixelFormat format = PixelFormat::kMjpeg;
  switch (recording.colour_coding) {
    case AzureColour::kMjpeg: break;
    case AzureColour::kYuy2: format = PixelFormat::kYuyv; break;
    case AzureColour::kBgra:
      format = PixelFormat::kBgr8;
      bytes = bgr_from_bgra(*bytes);
      break;
    case AzureColour::kNv12:
      format = PixelFormat::kYuyv;
      if (width % 2 != 0 || height % 2 != 0 || bytes->size() != width * height / 2 * 3) {
        return Error{ErrorCode::kInput, "an NV12 picture has " + std::to_string(bytes->size()) + " bytes, expected " +
                                            std::to_string(width * height / 2 * 3)};
      }
      bytes = yuyv_from_nv12(*bytes, width, height);
  }
  return raw_frame(StreamKind::kColour, format, track, index, *std::move(bytes));
}

Result<void> decode_colour(const AzureRecording& recording, std::size_t index, const Limits& limits,
                           DecodedFrame& frame) {
  const auto raw = raw_colour(recording, index, limits);
  if (!raw) return raw.error();
  auto image = decode_raw_colour(*raw, limits);
  if (!image) return image.error();
  const AzureLens& lens = recording.colour_lens;
  frame.colour_camera = lens.camera;
  frame.T_colour_depth = recording.T_colour_depth;
  if (lens.distortion != RationalDistortion{}) {
    frame.colour = undistort(*image, lens.camera, lens.distortion);
    return {};
  }
  frame.colour = *std::move(image);
  if (raw->profile.format == PixelFormat::kMjpeg) frame.encoded_colour = raw->bytes;
  return {};
}

OrDrop<DecodedFrame> decode(const AzureRecording& recording, const FrameEntry& entry, const DecodeSettings& settings) {
  auto depth_m = decode_depth(recording, entry.depth_index, settings);
  if (!depth_m) return make_drop(DropReason::kUnreadable, depth_m.error().message, entry.depth);
  DecodedFrame frame;
  frame.depth_m = *std::move(depth_m);
  if (recording.depth_lens) {
    const AzureLens& lens = *recording.depth_lens;
    frame.camera = lens.camera;
    if (lens.distortion != RationalDistortion{}) frame.depth_m = undistort(frame.depth_m, lens.camera, lens.distortion);
  }
  if (entry.colour.empty()) return frame;
  if (const auto colour = decode_colour(recording, entry.colour_index, settings.limits, frame); !colour) {
    return make_drop(DropReason::kUnreadable, colour.error().message, entry.colour);
  }
  return frame;
}

/// The track that the tag names by its UID, else the one of this name.
const MkvTrack* find_track(const MkvFile& mkv, const char* tag, const char* name) {
  const auto tagged = mkv.tags.find(tag);
  for (const MkvTrack& track : mkv.tracks) {
    if (track.is_video && tagged != mkv.tags.end() && tagged->second == std::to_string(track.uid)) return &track;
  }
  for (const MkvTrack& track : mkv.tracks) {
    if (track.is_video && track.name == name) return &track;
  }
  return nullptr;
}

std::string list_tracks(const MkvFile& mkv) {
  std::string list;
  for (const MkvTrack& track : mkv.tracks) {
    list += (list.empty() ? "" : ", ") +
            (track.name.empty() ? "track " + std::to_string(track.number) : shown(track.name)) + " (" +
            coding_of(track) + ")";
  }
  return list.empty() ? "none" : list;
}

bool has_size(const MkvTrack& track) {
  return track.width > 0 && track.height > 0 && track.width < kMostPictureSide && track.height < kMostPictureSide;
}

/// Errors: there is no depth that can be read.
Result<MkvTrack> depth_track(const MkvFile& mkv) {
  const MkvTrack* track = find_track(mkv, "K4A_DEPTH_TRACK", "DEPTH");
  if (track == nullptr) {
    return Error{ErrorCode::kInput,
                 "a Matroska file without depth: expected a track DEPTH, as Azure Kinect's recorder "
                 "writes it; its tracks: " +
                     list_tracks(mkv)};
  }
  if (track->fourcc != "b16g" || track->is_packed) {
    return Error{ErrorCode::kInput,
                 "its depth is coded as '" + coding_of(*track) + "'" +
                     (track->is_packed ? " and packed by Matroska" : "") +
                     ", which is not read; expected b16g, plain, as Azure Kinect's recorder writes it"};
  }
  if (!has_size(*track)) return Error{ErrorCode::kInput, "its depth track does not say how large its pictures are"};
  return *track;
}

Result<AzureCalibration> calibration_of(const MkvFile& mkv) {
  const auto tag = mkv.tags.find("K4A_CALIBRATION_FILE");
  const auto file = mkv.attached.find(tag == mkv.tags.end() ? "calibration.json" : tag->second);
  if (file == mkv.attached.end()) return Error{ErrorCode::kInput, "no calibration.json is attached"};
  auto parsed = parse_azure_calibration(file->second);
  if (!parsed) return Error{ErrorCode::kInput, "the attached calibration cannot be read: " + parsed.error().message};
  return parsed;
}

Result<AzureLens> depth_lens_of(const Result<AzureCalibration>& calibration, const MkvTrack& track) {
  if (!calibration) return calibration.error();
  if (!calibration->depth) return calibration->depth.error();
  const auto camera =
      azure_depth_camera(*calibration->depth, static_cast<int>(track.width), static_cast<int>(track.height));
  if (!camera) return camera.error();
  return AzureLens{*camera, calibration->depth->distortion};
}

/// Sets what is needed to read colour. Errors: why it is not read.
Result<void> set_colour(const MkvFile& mkv, const MkvTrack& track, const Result<AzureCalibration>& calibration,
                        AzureRecording& recording) {
  const auto coding = colour_of(track);
  if (!coding || track.is_packed) {
    return Error{ErrorCode::kInput, "it is coded as '" + coding_of(track) + "'" +
                                        (track.is_packed ? " and packed by Matroska" : "") +
                                        " (read are MJPG, NV12, YUY2, BGRA, plain)"};
  }
  if (!has_size(track)) return Error{ErrorCode::kInput, "its track does not say how large its pictures are"};
  if (!calibration)
    return Error{ErrorCode::kInput, "where its camera is, is not known: " + calibration.error().message};
  if (!calibration->colour) return calibration->colour.error();
  if (!calibration->depth) return calibration->depth.error();
  recording.colour_track = track;
  recording.colour_coding = *coding;
  recording.colour_lens = {
      azure_colour_camera(*calibration->colour, static_cast<int>(track.width), static_cast<int>(track.height)),
      calibration->colour->distortion};
  recording.T_colour_depth = calibration->colour->T_camera_device * calibration->depth->T_camera_device.inverse();
  const auto blocks = mkv.blocks.find(track.number);
  if (blocks != mkv.blocks.end()) recording.colour = blocks->second;
  return {};
}

std::vector<std::int64_t> times_of(const std::vector<MkvBlock>& blocks) {
  std::vector<std::int64_t> times_ns;
  for (const MkvBlock& block : blocks) times_ns.push_back(block.time_ns);
  return times_ns;
}

void add_entries(const AzureRecording& azure, Recording& recording) {
  StreamProfile profile;
  constexpr double kSecond_ns = 1e9;
  const auto period_ns = static_cast<double>(azure.colour_track.period_ns);
  constexpr double kShortest_ns = 1e6, kLongest_ns = 1e9;
  if (period_ns >= kShortest_ns && period_ns <= kLongest_ns) profile.frames_per_second = kSecond_ns / period_ns;
  const auto partners = pair_by_time(times_of(azure.depth), times_of(azure.colour), pairing_reach_ns(profile));
  const SharedPath file = recording.folder;
  for (std::size_t i = 0; i < azure.depth.size(); ++i) {
    FrameEntry entry{.sequence = i, .timestamp_ns = azure.depth[i].time_ns};
    entry.depth = file;
    entry.depth_index = i;
    if (partners[i]) {
      entry.colour = file;
      entry.colour_index = *partners[i];
    }
    recording.entries.push_back(std::move(entry));
  }
}

void tell_mkv_faults(const MkvFile& mkv, std::size_t frames, Recording& recording) {
  if (mkv.is_torn) {
    recording.warnings.push_back("the recording is torn: it is read up to where it is damaged or cut off, " +
                                 std::to_string(frames) + " depth pictures");
  }
  if (mkv.laced > 0) {
    recording.warnings.push_back(std::to_string(mkv.laced) +
                                 " blocks hold several pictures each (lacing), which are not read");
  }
}

}  // namespace

bool fits_azure_mkv(const RandomAccess& file) {
  return is_matroska(file);
}

Result<Recording> index_azure_mkv(std::unique_ptr<RandomAccess> file, const fs::path& path,
                                  const AcquireConfig& config) {
  MkvFile mkv = survey_mkv(*file, config.limits);
  auto track = depth_track(mkv);
  if (!track) return Error{ErrorCode::kInput, track.error().message, path.string()};
  const auto azure = std::make_shared<AzureRecording>();
  azure->file = std::move(file);
  azure->depth_track = *std::move(track);
  const auto calibration = calibration_of(mkv);
  if (!config.intrinsics) {
    const auto lens = depth_lens_of(calibration, azure->depth_track);
    if (!lens) {
      return Error{ErrorCode::kInput, "the depth camera is not known: " + lens.error().message + kStateCamera,
                   path.string()};
    }
    azure->depth_lens = *lens;
  }
  Recording recording{.format = "azure-mkv", .folder = path, .device = shown(mkv.title)};
  recording.frames_bring_camera = azure->depth_lens.has_value();
  if (const MkvTrack* colour = find_track(mkv, "K4A_COLOR_TRACK", "COLOR")) {
    const auto set = set_colour(mkv, *colour, calibration, *azure);
    if (!set) recording.warnings.push_back("colour is not read: " + set.error().message);
    if (config.camera && config.camera->colour) azure->colour_lens.distortion = {};  // straightened by what is stated
  }
  if (const auto blocks = mkv.blocks.find(azure->depth_track.number); blocks != mkv.blocks.end()) {
    azure->depth = std::move(blocks->second);
  }
  tell_mkv_faults(mkv, azure->depth.size(), recording);
  add_entries(*azure, recording);
  recording.decode = [azure = std::shared_ptr<const AzureRecording>(azure)](const FrameEntry& entry,
                                                                            const DecodeSettings& settings) {
    return decode(*azure, entry, settings);
  };
  return recording;
}

}  // namespace scanknit
