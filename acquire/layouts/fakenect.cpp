// Dumps of libfreenect's recorder (fakenect-record), and ours: INDEX.txt, d-HOST-DEVICE.pgm, r-HOST-DEVICE.ppm.

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "acquire/mcap/byte_appender.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/replay/camera_files.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/byte_reader.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIndex = "INDEX.txt";
constexpr unsigned kNoReturn = 2047;  // of eleven bits

struct DumpedFile {
  fs::path path;
  std::int64_t host_ns = 0;
};

struct Dump {
  std::vector<DumpedFile> depth, colour;
  bool is_disparity = false;  // the Kinect's own eleven bits; else units that camera_intrinsic.json states
  Limits limits;
};

// "d-1263.123456-789.pgm": what it is, and the seconds of the host. The device's clock wraps round each 72 s.
std::optional<std::int64_t> host_time(std::string_view name) {
  if (name.size() < 3 || name[1] != '-') return std::nullopt;
  const std::string_view rest = name.substr(2);
  return parse_seconds_ns(rest.substr(0, rest.find('-')));
}

// Metres of the Kinect v1's disparity: 0.1236 tan(d / 2842.5 + 1.1863) (S. Magnenat, OpenKinect's page "Imaging
// Information", 2011), here in whole millimetres.
std::uint16_t millimetres(unsigned disparity) {
  if (disparity >= kNoReturn) return 0;
  const double metres = 0.1236 * std::tan(disparity / 2842.5 + 1.1863);
  return metres > 0 && metres < 10 ? static_cast<std::uint16_t>(std::lround(1000 * metres)) : std::uint16_t{0};
}

// The picture after a header of one line, "P5 640 480 65535".
Result<RawFrame> parse_pnm(std::span<const std::byte> bytes, StreamKind kind, const Limits& limits) {
  const bool is_depth = kind == StreamKind::kDepth;
  constexpr std::size_t kLongestHeader = 64;
  std::string header;
  ByteReader reader(bytes);
  for (char c = '\0'; c != '\n' && header.size() < kLongestHeader; header += c) {
    const auto next = reader.little_endian<char>();
    if (!next) return Error{ErrorCode::kInput, "truncated"};
    c = *next;
  }
  const auto lines = text_lines(header);
  const char* magic = is_depth ? "P5" : "P6";
  const char* highest = is_depth ? "65535" : "255";
  const bool is_known =
      lines.size() == 1 && lines[0].words.size() == 4 && lines[0].words[0] == magic && lines[0].words[3] == highest;
  const auto width = is_known ? parse_double(lines[0].words[1]) : std::nullopt;
  const auto height = is_known ? parse_double(lines[0].words[2]) : std::nullopt;
  const auto is_side = [&](const std::optional<double>& side) {
    return side && *side >= 1 && *side <= 65535 && *side == std::floor(*side);
  };
  if (!is_side(width) || !is_side(height) || *width * *height > static_cast<double>(limits.max_image_pixels)) {
    return Error{ErrorCode::kInput, fmt::format("expected a header {} WIDTH HEIGHT {}", magic, highest)};
  }
  RawFrame frame;
  frame.profile = {kind, is_depth ? PixelFormat::kZ16 : PixelFormat::kRgb8, static_cast<int>(*width),
                   static_cast<int>(*height), 30};
  const auto pixels = reader.take(static_cast<std::size_t>(*width * *height) * (is_depth ? 2 : 3));
  if (!pixels) return Error{ErrorCode::kInput, "truncated"};
  frame.bytes = std::make_shared<const std::vector<std::byte>>(pixels->begin(), pixels->end());
  return frame;
}

std::shared_ptr<const std::vector<std::byte>> to_millimetres(std::span<const std::byte> disparity) {
  std::vector<std::byte> bytes;
  bytes.reserve(disparity.size());
  ByteReader reader(disparity);
  ByteAppender writer(bytes);
  while (const auto d = reader.little_endian<std::uint16_t>()) writer.little_endian(millimetres(*d));
  return std::make_shared<const std::vector<std::byte>>(std::move(bytes));
}

Result<RawFrame> read_dumped(const Dump& dump, StreamKind kind, std::size_t index) {
  const DumpedFile& file = (kind == StreamKind::kDepth ? dump.depth : dump.colour)[index];
  const auto bytes = read_file(file.path, dump.limits.max_image_bytes);
  if (!bytes) return Error{ErrorCode::kInput, file.path.filename().string() + ": " + bytes.error().message};
  auto frame = parse_pnm(*bytes, kind, dump.limits);
  if (!frame) return Error{ErrorCode::kInput, file.path.filename().string() + ": " + frame.error().message};
  if (kind == StreamKind::kDepth && dump.is_disparity) frame->bytes = to_millimetres(*frame->bytes);
  frame->sequence = index;
  frame->device_ns = frame->host_ns = file.host_ns;
  return frame;
}

std::vector<RawStamp> stamps_of(const std::vector<DumpedFile>& files) {
  std::vector<RawStamp> stamps;
  for (const DumpedFile& file : files) stamps.push_back({stamps.size(), file.host_ns});
  return stamps;
}

}  // namespace

bool fits_fakenect(const Folder& folder, const Limits&) {
  return folder.has_file(kIndex) && std::any_of(folder.files.begin(), folder.files.end(), [](const std::string& name) {
           return name.starts_with("d-") && name.ends_with(".pgm");
         });
}

Result<Recording> index_fakenect(const Folder& folder, const AcquireConfig& config) {
  const auto text = read_text_file(folder.path / kIndex, config.limits.max_text_bytes);
  if (!text) return text.error();
  auto dump = std::make_shared<Dump>();
  dump->limits = config.limits;
  for (const TextLine& line : text_lines(*text)) {
    const std::string_view name = line.words[0];
    const auto time = host_time(name);
    const bool is_depth = name.starts_with("d-");
    if (!is_depth && !name.starts_with("r-")) continue;  // "a-": the accelerometer
    auto path = resolve_inside(folder.path, name);
    if (!time || std::holds_alternative<Drop>(path)) {
      return Error{ErrorCode::kInput, "expected a name such as d-12.345678-90.pgm",
                   (folder.path / kIndex).string() + ":" + std::to_string(line.number)};
    }
    (is_depth ? dump->depth : dump->colour).push_back({std::get<fs::path>(std::move(path)), *time});
  }
  RawRecording raw{.format = "fakenect", .file = folder.path};
  const auto camera = find_camera(folder.path, config.limits);
  if (!camera) return camera.error();
  if (*camera) raw.calibration.depth.intrinsics = **camera;
  const auto units = find_depth_scale(folder.path, config.limits);
  if (!units) return units.error();
  dump->is_disparity = !units->has_value();
  raw.calibration.depth_unit_m = 1 / units->value_or(1000.0);
  raw.depth = stamps_of(dump->depth);
  raw.colour = stamps_of(dump->colour);
  raw.read = [dump](StreamKind kind, std::size_t index) { return read_dumped(*dump, kind, index); };
  return index_raw_recording(std::move(raw), config);
}

}  // namespace scanknit
