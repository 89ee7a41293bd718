// ScanNet's .sens (Dai et al. 2017; github.com/ScanNet/ScanNet, SensReader): one file of a walk with a depth camera.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "acquire/raw/raw_recording.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kVersion4 = 4;
constexpr std::uint64_t kMostNameBytes = 4096;
constexpr std::uint32_t kMostSide = 1u << 16;
constexpr std::size_t kMatrixBytes = 16 * sizeof(float);
constexpr std::size_t kFixedBytes = 4 * kMatrixBytes + 2 * 4 + 4 * 4 + 4 + 8;  // from the first matrix to the frames
constexpr std::size_t kFrameBytes = kMatrixBytes + 4 * 8;                      // before a frame's pictures

enum class SensColour : std::int32_t { kRaw = 0, kPng = 1, kJpeg = 2 };
enum class SensDepth : std::int32_t { kRaw = 0, kZlib = 1 };

struct SensHeader {
  std::string sensor;
  Eigen::Matrix4d colour_camera, T_colour, depth_camera, T_depth;
  SensColour colour_coding = SensColour::kRaw;
  SensDepth depth_coding = SensDepth::kRaw;
  std::uint32_t colour_width = 0, colour_height = 0, depth_width = 0, depth_height = 0;
  double units_per_metre = 0;
  std::uint64_t frames = 0;
  std::uint64_t frames_at = 0;  ///< the place of the first frame
};

struct SensFrame {
  Eigen::Matrix4d T_world_camera;
  std::int64_t depth_us = 0;
  std::uint64_t colour_at = 0, colour_bytes = 0, depth_at = 0, depth_bytes = 0;
};

Eigen::Matrix4d take_matrix(ByteReader& reader) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = static_cast<double>(reader.little_endian<float>().value_or(NAN));
  return matrix;
}

/// Nothing: the file is no .sens, or of another version.
std::optional<SensHeader> read_sens_header(const RandomAccess& file) {
  std::array<std::byte, 4 + 8> first{};
  if (!file.read(0, first)) return std::nullopt;
  ByteReader start(first);
  const auto version = *start.little_endian<std::uint32_t>();
  const auto name_bytes = *start.little_endian<std::uint64_t>();
  if (version != kVersion4 || name_bytes > kMostNameBytes) return std::nullopt;
  std::vector<std::byte> rest(static_cast<std::size_t>(name_bytes) + kFixedBytes);
  if (!file.read(first.size(), rest)) return std::nullopt;
  ByteReader reader(rest);
  SensHeader header;
  const auto name = reader.take(static_cast<std::size_t>(name_bytes)).value_or(std::span<const std::byte>());
  for (const std::byte letter : name) header.sensor += std::to_integer<char>(letter);
  header.colour_camera = take_matrix(reader);
  header.T_colour = take_matrix(reader);
  header.depth_camera = take_matrix(reader);
  header.T_depth = take_matrix(reader);
  header.colour_coding = static_cast<SensColour>(*reader.little_endian<std::int32_t>());
  header.depth_coding = static_cast<SensDepth>(*reader.little_endian<std::int32_t>());
  header.colour_width = *reader.little_endian<std::uint32_t>();
  header.colour_height = *reader.little_endian<std::uint32_t>();
  header.depth_width = *reader.little_endian<std::uint32_t>();
  header.depth_height = *reader.little_endian<std::uint32_t>();
  header.units_per_metre = static_cast<double>(*reader.little_endian<float>());
  header.frames = *reader.little_endian<std::uint64_t>();
  header.frames_at = first.size() + rest.size();
  const auto is_side = [](std::uint32_t side) { return side > 0 && side < kMostSide; };
  const bool is_plausible = is_side(header.depth_width) && is_side(header.depth_height) &&
                            header.colour_width < kMostSide && header.colour_height < kMostSide &&
                            std::isfinite(header.units_per_metre) && header.units_per_metre > 0;
  return is_plausible ? std::optional(std::move(header)) : std::nullopt;
}

/// Frames whose times do not ascend have no clock: they are taken to be thirty a second.
void settle_times(std::vector<SensFrame>& frames) {
  constexpr std::int64_t kPeriod_us = 33'333;
  const auto is_later = [](const SensFrame& a, const SensFrame& b) { return a.depth_us >= b.depth_us; };
  if (std::adjacent_find(frames.begin(), frames.end(), is_later) == frames.end()) return;
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].depth_us = static_cast<std::int64_t>(i) * kPeriod_us;
}

/// All frames that are whole, in the order of the file.
std::vector<SensFrame> list_sens_frames(const RandomAccess& file, const SensHeader& header, const Limits& limits) {
  std::vector<SensFrame> frames;
  std::uint64_t at = header.frames_at;
  while (frames.size() < header.frames && frames.size() <= limits.max_frames) {
    std::array<std::byte, kFrameBytes> raw{};
    if (at > file.size() || !file.read(at, raw)) break;
    ByteReader reader(raw);
    SensFrame frame;
    frame.T_world_camera = take_matrix(reader);
    (void)reader.little_endian<std::uint64_t>();  // colour's time
    const auto depth_us = *reader.little_endian<std::uint64_t>();
    frame.depth_us = depth_us < std::uint64_t{1} << 53 ? static_cast<std::int64_t>(depth_us) : 0;
    frame.colour_bytes = *reader.little_endian<std::uint64_t>();
    frame.depth_bytes = *reader.little_endian<std::uint64_t>();
    frame.colour_at = at + kFrameBytes;
    if (frame.colour_bytes > file.size() - frame.colour_at) break;
    frame.depth_at = frame.colour_at + frame.colour_bytes;
    if (frame.depth_bytes > file.size() - frame.depth_at) break;
    at = frame.depth_at + frame.depth_bytes;
    frames.push_back(std::move(frame));
  }
  settle_times(frames);
  return frames;
}

CameraIntrinsics camera_of(const Eigen::Matrix4d& k, std::uint32_t width, std::uint32_t height) {
  return {static_cast<int>(width), static_cast<int>(height), k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
}

class SensFile {
 public:
  SensFile(std::unique_ptr<RandomAccess> file, SensHeader header, std::vector<SensFrame> frames, const Limits& limits)
      : file_(std::move(file)), header_(std::move(header)), frames_(std::move(frames)), limits_(limits) {}

  [[nodiscard]] Result<RawFrame> read(StreamKind kind, std::size_t index) const {
    const SensFrame& frame = frames_.at(index);
    const bool is_depth = kind == StreamKind::kDepth;
    auto bytes =
        is_depth ? read_bytes(frame.depth_at, frame.depth_bytes) : read_bytes(frame.colour_at, frame.colour_bytes);
    if (!bytes) return bytes.error();
    if (is_depth && header_.depth_coding == SensDepth::kZlib) bytes = unpacked_depth(*bytes);
    if (!bytes) return bytes.error();
    // A picture file is decoded by what it is.
    const PixelFormat colour = header_.colour_coding == SensColour::kRaw ? PixelFormat::kRgb8 : PixelFormat::kMjpeg;
    RawFrame raw;
    raw.profile = {kind, is_depth ? PixelFormat::kZ16 : colour,
                   static_cast<int>(is_depth ? header_.depth_width : header_.colour_width),
                   static_cast<int>(is_depth ? header_.depth_height : header_.colour_height)};
    raw.sequence = index;
    raw.device_ns = frame.depth_us * 1000;
    raw.host_ns = raw.device_ns;
    raw.bytes = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
    return raw;
  }

 private:
  [[nodiscard]] Result<std::vector<std::byte>> read_bytes(std::uint64_t at, std::uint64_t count) const {
    if (count > limits_.max_image_bytes) return Error{ErrorCode::kInput, "a picture has too many bytes"};
    std::vector<std::byte> bytes(static_cast<std::size_t>(count));
    if (!file_->read(at, bytes)) return Error{ErrorCode::kInput, "a picture cannot be read; did the file change?"};
    return bytes;
  }

  [[nodiscard]] Result<std::vector<std::byte>> unpacked_depth(const std::vector<std::byte>& packed) const {
    const std::uint64_t pixels = std::uint64_t{header_.depth_width} * header_.depth_height;
    if (pixels > static_cast<std::uint64_t>(limits_.max_image_pixels)) {
      return Error{ErrorCode::kInput, "the depth picture is too large"};
    }
    std::vector<std::byte> depth(static_cast<std::size_t>(2 * pixels));
    uLongf count = depth.size();
    const int status = uncompress(reinterpret_cast<Bytef*>(depth.data()), &count,
                                  reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    if (status != Z_OK || count != depth.size()) {
      return Error{ErrorCode::kInput, "the depth picture is damaged: zlib does not unpack it to its size"};
    }
    return depth;
  }

  std::unique_ptr<RandomAccess> file_;
  SensHeader header_;
  std::vector<SensFrame> frames_;
  Limits limits_;
};

/// Without colour where the file holds none that is read; `warnings` say why.
bool has_colour(const SensHeader& header, std::vector<std::string>& warnings) {
  if (header.colour_width == 0 || header.colour_height == 0) return false;
  if (header.colour_coding < SensColour::kRaw || header.colour_coding > SensColour::kJpeg) {
    warnings.push_back("colour is not read: it is packed in a way that is not known");
    return false;
  }
  constexpr double kSame = 1e-6;
  if (header.T_colour.isApprox(header.T_depth, kSame)) return true;
  warnings.push_back("colour is not read: it is not aligned with depth (the extrinsics differ)");
  return false;
}

}  // namespace

bool fits_sens(const RandomAccess& file) {
  return read_sens_header(file).has_value();
}

Result<Recording> index_sens(std::unique_ptr<RandomAccess> access, const std::filesystem::path& path,
                             const AcquireConfig& config) {
  auto header = read_sens_header(*access);
  if (!header) return Error{ErrorCode::kInput, "is no .sens file of ScanNet", path.string()};
  if (header->depth_coding != SensDepth::kRaw && header->depth_coding != SensDepth::kZlib) {
    return Error{ErrorCode::kInput, "its depth is packed in a way that is not read (plain and zlib are)",
                 path.string()};
  }
  auto frames = list_sens_frames(*access, *header, config.limits);
  RawRecording raw{.format = "sens", .file = path};
  raw.calibration.device = header->sensor;
  raw.calibration.depth = {camera_of(header->depth_camera, header->depth_width, header->depth_height), {}};
  raw.calibration.depth_unit_m = 1 / header->units_per_metre;
  const bool with_colour = has_colour(*header, raw.warnings);
  if (with_colour) {
    raw.calibration.colour = {camera_of(header->colour_camera, header->colour_width, header->colour_height), {}};
  }
  if (frames.size() < header->frames) {
    raw.warnings.push_back("the recording is torn: " + std::to_string(frames.size()) + " of " +
                           std::to_string(header->frames) + " frames are whole");
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const RawStamp stamp{i, frames[i].depth_us * 1000};
    raw.depth.push_back(stamp);
    if (with_colour) raw.colour.push_back(stamp);  // the pictures of a frame belong together
    raw.T_world_camera.emplace(i, pose_from_matrix(frames[i].T_world_camera));
  }
  const auto file =
      std::make_shared<const SensFile>(std::move(access), *std::move(header), std::move(frames), config.limits);
  raw.read = [file](StreamKind kind, std::size_t index) { return file->read(kind, index); };
  return index_raw_recording(std::move(raw), config);
}

}  // namespace scanknit
