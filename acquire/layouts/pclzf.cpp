// PCLZF frames of PCL's image grabber: NAME_depth.pclzf, NAME_rgb.pclzf, NAME.xml. PCL unpacks and reads the
// parameters; the header is checked here first.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <string>

#include "acquire/pcl/acquire_pcl.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/byte_reader.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDepthSuffix = "_depth.pclzf";
constexpr std::string_view kColourSuffix = "_rgb.pclzf";
constexpr std::string_view kMagic = "PCLZF";
constexpr std::size_t kTypeBytes = 16;
// The parameter file has some 500 bytes. Its parser is recursive: a small file cannot nest deeply enough to hurt.
constexpr std::uintmax_t kMaxParameterBytes = 8u << 10;

struct PclzfImage {
  int width = 0;
  int height = 0;
  std::vector<char> pixels;
};

std::string text_of(std::span<const std::byte> bytes) {
  std::string text(bytes.size(), '\0');
  if (!bytes.empty()) std::memcpy(text.data(), bytes.data(), bytes.size());
  return text;
}

// "PCLZF", width, height, 16 characters of type, compressed and uncompressed size; then LZF data (PCL, lzf_image_io).
Result<PclzfImage> unpack(std::span<const std::byte> bytes, std::string_view type, std::size_t pixel_bytes,
                          const Limits& limits) {
  const auto broken = [](const std::string& what) { return Error{ErrorCode::kInput, "PCLZF: " + what}; };
  if (bytes.empty()) return Error{ErrorCode::kInput, "the file is empty"};
  ByteReader reader(bytes);
  const auto magic = reader.take(kMagic.size());
  if (!magic || text_of(*magic) != kMagic) return broken("not a PCLZF file");
  const auto width = reader.little_endian<std::uint32_t>();
  const auto height = reader.little_endian<std::uint32_t>();
  const auto type_bytes = reader.take(kTypeBytes);
  const auto compressed = reader.little_endian<std::uint32_t>();
  const auto uncompressed = reader.little_endian<std::uint32_t>();
  if (!width || !height || !type_bytes || !compressed || !uncompressed) return broken("truncated");
  const std::string found = text_of(*type_bytes).substr(0, text_of(*type_bytes).find_last_not_of(' ') + 1);
  if (found != type) return broken("holds '" + found + "', expected '" + std::string(type) + "'");
  const std::uint64_t pixels = std::uint64_t{*width} * *height;
  if (pixels == 0 || pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return broken(std::to_string(*width) + " x " + std::to_string(*height) + " pixels is not read");
  }
  if (*uncompressed != pixels * pixel_bytes) return broken("its sizes contradict each other");
  const auto data = reader.take(*compressed);
  if (!data || data->empty()) return broken("truncated");

  const auto pcl = load_acquire_pcl();
  if (!pcl) return pcl.error();
  auto pixel_data = (*pcl)->unpack_lzf(*data, *uncompressed);
  if (!pixel_data) return broken("its compressed data are corrupt");
  return PclzfImage{static_cast<int>(*width), static_cast<int>(*height), *std::move(pixel_data)};
}

Image<std::uint16_t> to_depth(const PclzfImage& image) {
  Image<std::uint16_t> raw(image.width, image.height);
  ByteReader reader(std::as_bytes(std::span(image.pixels)));
  for (std::uint16_t& value : raw.pixels()) value = reader.little_endian<std::uint16_t>().value_or(0);
  return raw;
}

// Planes: all red, then all green, then all blue.
ColourImage to_colour(const PclzfImage& image) {
  ColourImage colour(image.width, image.height);
  const std::size_t plane = colour.size();
  for (std::size_t i = 0; i < plane; ++i) {
    colour.pixels()[i] = {static_cast<std::uint8_t>(image.pixels[i]),
                          static_cast<std::uint8_t>(image.pixels[plane + i]),
                          static_cast<std::uint8_t>(image.pixels[2 * plane + i])};
  }
  return colour;
}

OrDrop<DecodedFrame> decode_pclzf_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  auto bytes = read_picture(entry.depth, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto depth = unpack(std::get<0>(bytes), "depth16", 2, settings.limits);
  if (!depth) return make_drop(DropReason::kUnreadable, depth.error().message, entry.depth);
  DecodedFrame frame;
  frame.depth_m = scale_depth(to_depth(*depth), settings.depth_scale);
  frame.camera = entry.camera.copy();
  if (frame.camera) {
    frame.camera->width = depth->width;
    frame.camera->height = depth->height;
  }
  if (entry.colour.empty()) return frame;
  bytes = read_picture(entry.colour, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto colour = unpack(std::get<0>(bytes), "rgb24", 3, settings.limits);
  if (!colour) return make_drop(DropReason::kUnreadable, colour.error().message, entry.colour);
  frame.colour = to_colour(*colour);
  frame.colour_camera = entry.colour_camera.copy();
  if (frame.colour_camera) {
    frame.colour_camera->width = colour->width;
    frame.colour_camera->height = colour->height;
  }
  return frame;
}

void read_parameters(const AcquirePcl& pcl, const fs::path& path, FrameEntry& entry) {
  const auto xml = read_text_file(path, kMaxParameterBytes);
  if (!xml) {
    entry.fault = make_drop(DropReason::kNoIntrinsics, xml.error().message, path);
    return;
  }
  const PclzfParameters parameters = pcl.read_pclzf_parameters(*xml);
  entry.camera = parameters.depth;
  const double metres_per_unit = parameters.metres_per_unit;
  // Units between a tenth of a micrometre and a metre, the range of acquire.depth_scale.
  if (metres_per_unit >= 1e-7 && metres_per_unit <= 1) entry.depth_scale = 1 / metres_per_unit;
  entry.colour_camera = parameters.colour;
}

// "frame_20121214T142255.814212": UTC to the microsecond.
std::optional<std::int64_t> time_in_name(std::string_view stem) {
  const std::size_t t = stem.find_last_of('T');
  if (t == std::string_view::npos || t < 8 || stem.size() < t + 7) return std::nullopt;
  const auto number = [&](std::size_t begin, std::size_t digits) {
    return numbered_name(stem.substr(begin, digits), "", "");
  };
  const auto year = number(t - 8, 4);
  const auto month = number(t - 4, 2);
  const auto day = number(t - 2, 2);
  const auto hour = number(t + 1, 2);
  const auto minute = number(t + 3, 2);
  const auto seconds_ns = parse_seconds_ns(stem.substr(t + 5));
  if (!year || !month || !day || !hour || !minute || !seconds_ns) return std::nullopt;
  constexpr std::uint64_t kFirstYear = 1970, kLastYear = 2261;  // whole years whose nanoseconds fit 64 bits
  constexpr std::int64_t kMinute_ns = 61'000'000'000;           // with a leap second
  if (*year < kFirstYear || *year > kLastYear || *hour > 23 || *minute > 59) return std::nullopt;
  if (*seconds_ns < 0 || *seconds_ns >= kMinute_ns) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok()) return std::nullopt;
  const std::chrono::nanoseconds midnight = std::chrono::sys_days(date).time_since_epoch();
  const auto whole = midnight + std::chrono::hours(*hour) + std::chrono::minutes(*minute);
  return whole.count() + *seconds_ns;
}

}  // namespace

bool fits_pclzf(const Folder& folder, const Limits&) {
  return std::any_of(folder.files.begin(), folder.files.end(),
                     [](const std::string& name) { return name.ends_with(kDepthSuffix); });
}

Result<Recording> index_pclzf(const Folder& folder, const AcquireConfig& config) {
  const auto pcl = load_acquire_pcl();
  if (!pcl) return pcl.error();
  Recording recording{.format = "pclzf", .folder = folder.path};
  recording.frames_bring_camera = true;
  recording.decode = decode_pclzf_frame;
  for (const std::string& name : folder.files) {
    if (!name.ends_with(kDepthSuffix)) continue;
    const std::string stem = name.substr(0, name.size() - kDepthSuffix.size());
    FrameEntry entry{.sequence = recording.entries.size(), .timestamp_ns = time_in_name(stem)};
    entry.depth = folder.path / name;
    const std::string colour = stem + std::string(kColourSuffix);
    if (folder.has_file(colour)) entry.colour = folder.path / colour;
    read_parameters(**pcl, folder.path / (stem + ".xml"), entry);
    if (config.intrinsics && entry.fault) entry.fault.reset();  // what the file would have said is stated
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
