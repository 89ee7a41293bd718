// Record3D's .r3d (record3d.app; by github.com/notmahi/clip-fields, dataloaders/record3d.py, and by nerfstudio's
// record3d_utils.py): a ZIP archive with metadata (JSON) and, for each frame, depth, confidence and a JPEG.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/opengl_pose.h"
#include "acquire/phones/lzfse.h"
#include "acquire/phones/zip_archive.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/files/located.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kMetadata = "metadata";
constexpr const char* kFrames = "rgbd/";
constexpr std::uint32_t kZipBegins = 0x04034b50;

// Depth of a LiDAR; files of older versions do not tell its size.
constexpr int kLidarShort = 192, kLidarLong = 256;

std::string name_in_archive(std::uint64_t number, const char* end) {
  return kFrames + std::to_string(number) + end;
}

/// The pictures of the archive, as they are needed.
struct Record3dFile {
  ZipArchive archive;
  int width = 0, height = 0;  ///< of depth

  /// Unpacked, of exactly `count` bytes.
  [[nodiscard]] Result<std::vector<std::byte>> unpacked(const std::string& name, std::size_t count,
                                                        const Limits& limits) const {
    const auto packed = archive.read(name, limits.max_image_bytes);
    if (!packed) return packed.error();
    auto bytes = unpack_lzfse(*packed, count);
    if (bytes && bytes->size() != count) {
      return Error{ErrorCode::kInput,
                   "has " + std::to_string(bytes->size()) + " bytes unpacked, expected " + std::to_string(count)};
    }
    return bytes;
  }
};

Result<DepthImage> read_record3d_depth(const Record3dFile& file, std::uint64_t number, const DecodeSettings& settings) {
  DepthImage depth_m(file.width, file.height);
  const auto bytes = file.unpacked(name_in_archive(number, ".depth"), 4 * depth_m.size(), settings.limits);
  if (!bytes) return bytes.error();
  ByteReader reader(*bytes);
  for (float& z : depth_m.pixels()) {
    const float value = reader.little_endian<float>().value_or(0);
    z = std::isfinite(value) && value > 0 ? value : 0;  // NaN: no return
  }
  const std::string confidence = name_in_archive(number, ".conf");
  if (settings.min_confidence <= 0 || !file.archive.entries().contains(confidence)) return depth_m;
  const auto trust = file.unpacked(confidence, depth_m.size(), settings.limits);
  if (!trust) return trust.error();
  for (std::size_t i = 0; i < trust->size(); ++i) {
    if (std::to_integer<int>((*trust)[i]) < settings.min_confidence) depth_m.pixels()[i] = 0;
  }
  return depth_m;
}

OrDrop<DecodedFrame> decode_record3d_frame(const FrameEntry& entry, const DecodeSettings& settings,
                                           const Record3dFile& file) {
  const auto drop = [](const Error& error, const fs::path& where) {
    return make_drop(DropReason::kUnreadable, error.message, where);
  };
  DecodedFrame frame;
  auto depth = read_record3d_depth(file, entry.sequence, settings);
  if (!depth) return drop(depth.error(), entry.depth);
  frame.depth_m = *std::move(depth);
  if (entry.camera) frame.camera = entry.camera->resized(file.width, file.height);
  if (entry.colour.empty()) return frame;
  auto bytes = file.archive.read(name_in_archive(entry.sequence, ".jpg"), settings.limits.max_image_bytes);
  if (!bytes) return drop(bytes.error(), entry.colour);
  auto colour = decode_picture(*bytes, settings.limits);
  if (!colour) return drop(colour.error(), entry.colour);
  frame.colour = *std::move(colour);
  if (entry.camera) frame.colour_camera = entry.camera->resized(frame.colour.width(), frame.colour.height());
  frame.encoded_colour = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
  return frame;
}

Result<Json> read_metadata(const ZipArchive& archive, const Limits& limits) {
  const auto bytes = archive.read(kMetadata, limits.max_text_bytes);
  if (!bytes) return bytes.error();
  std::string text;
  for (const std::byte letter : *bytes) text += std::to_integer<char>(letter);
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return Error{ErrorCode::kInput, "its metadata is no JSON object"};
  return json;
}

/// The n-th of a list; null where there is none.
const Json* item(const Json& json, const char* key, std::uint64_t number) {
  const auto list = json.find(key);
  return list != json.end() && list->is_array() && number < list->size() ? &(*list)[number] : nullptr;
}

/// Of the JPEG: the frame's own fx, fy, cx, cy, else K, column by column.
std::optional<CameraIntrinsics> record3d_camera(const Json& json, std::uint64_t number) {
  CameraIntrinsics camera{json_side(json, "w").value_or(0), json_side(json, "h").value_or(0)};
  const Json* own = item(json, "perFrameIntrinsicCoeffs", number);
  if (const auto k = own != nullptr ? json_list(*own, 4) : std::nullopt) {
    std::tie(camera.fx, camera.fy, camera.cx, camera.cy) = std::tie((*k)[0], (*k)[1], (*k)[2], (*k)[3]);
  } else if (const auto all = json_numbers(json, "K", 9)) {
    std::tie(camera.fx, camera.fy, camera.cx, camera.cy) = std::tie((*all)[0], (*all)[4], (*all)[6], (*all)[7]);
  }
  return camera.is_valid() ? std::optional(camera) : std::nullopt;
}

/// "qx qy qz qw x y z", ARKit's axes.
std::optional<Result<Pose>> record3d_pose(const Json& json, std::uint64_t number) {
  const Json* stated = item(json, "poses", number);
  if (stated == nullptr) return std::nullopt;
  const auto p = json_list(*stated, 7);
  if (!p) return Error{ErrorCode::kInput, "poses: expected seven numbers each"};
  const auto arkit = pose_from_quaternion({(*p)[4], (*p)[5], (*p)[6]}, {(*p)[0], (*p)[1], (*p)[2], (*p)[3]});
  return arkit ? pose_from_opengl(arkit->matrix()) : arkit;
}

/// Its own time, else by the frames per second.
std::optional<std::int64_t> record3d_time(const Json& json, std::uint64_t number) {
  constexpr double kMostSeconds = 9.0e9;  // 2^63 ns is 9.22e9 s
  const Json* own = item(json, "frameTimestamps", number);
  const double rate = json_number(json, "fps").value_or(0);
  double seconds = rate > 0 ? static_cast<double>(number) / rate : std::numeric_limits<double>::infinity();
  if (own != nullptr && own->is_number()) seconds = own->get<double>();
  return std::abs(seconds) <= kMostSeconds ? std::optional(std::llround(seconds * 1e9)) : std::nullopt;
}

/// Those whose depth is in the archive.
std::vector<std::uint64_t> record3d_frames(const ZipArchive& archive) {
  std::vector<std::uint64_t> numbers;
  for (const auto& [name, unused] : archive.entries()) {
    if (const auto number = numbered_name(name, kFrames, ".depth")) numbers.push_back(*number);
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());  // "7" and "07"
  return numbers;
}

}  // namespace

bool fits_record3d(const RandomAccess& file) {
  std::array<std::byte, 4> first{};
  if (!file.read(0, first) || ByteReader(first).little_endian<std::uint32_t>() != kZipBegins) return false;
  // Not owned: the archive does not outlive this call.
  const auto archive = ZipArchive::open({std::shared_ptr<const RandomAccess>(), &file}, Limits{});
  return archive && archive->entries().contains(kMetadata) && !record3d_frames(*archive).empty();
}

Result<Recording> index_record3d(std::unique_ptr<RandomAccess> access, const fs::path& path,
                                 const AcquireConfig& config) {
  auto archive = ZipArchive::open(std::move(access), config.limits);
  if (!archive) return located(archive.error(), path);
  const auto json = read_metadata(*archive, config.limits);
  if (!json) return located(json.error(), path);
  Recording recording{.format = "record3d", .folder = path};
  recording.has_metric_depth = true;
  recording.frames_bring_camera = true;
  recording.world_up = UpAxis::kY;  // ARKit's worlds stand upright
  if (archive->is_torn()) {
    recording.warnings.push_back(
        "the archive is torn: its list of files is missing, and only those are read that are "
        "whole");
  }
  const bool is_upright = json_side(*json, "w").value_or(0) <= json_side(*json, "h").value_or(0);
  Record3dFile file{*std::move(archive), json_side(*json, "dw").value_or(is_upright ? kLidarShort : kLidarLong),
                    json_side(*json, "dh").value_or(is_upright ? kLidarLong : kLidarShort)};
  const std::int64_t pixels = std::int64_t{file.width} * file.height;
  if (pixels > config.limits.max_image_pixels) {
    return Error{ErrorCode::kInput, "its depth has more pixels than the limit", path.string()};
  }
  if (!config.sensor && pixels == kLidarShort * kLidarLong) {
    recording.sensor = RecognisedSensor{SensorModel::kPhoneLidar, "its depth has the size of a phone's LiDAR"};
  }
  for (const std::uint64_t number : record3d_frames(file.archive)) {
    FrameEntry entry{.sequence = number, .timestamp_ns = record3d_time(*json, number)};
    entry.depth = path / name_in_archive(number, ".depth");
    if (file.archive.entries().contains(name_in_archive(number, ".jpg"))) {
      entry.colour = path / name_in_archive(number, ".jpg");
    }
    entry.camera = record3d_camera(*json, number);
    auto pose = record3d_pose(*json, number);
    if (pose && !*pose) pose = Result<Pose>(located(pose->error(), path / kMetadata));
    entry.T_world_camera = std::move(pose);
    recording.entries.push_back(std::move(entry));
  }
  recording.decode = [file = std::make_shared<const Record3dFile>(std::move(file))](const FrameEntry& entry,
                                                                                    const DecodeSettings& settings) {
    return decode_record3d_frame(entry, settings, *file);
  };
  return recording;
}

}  // namespace scanknit
