#include "acquire/layouts/oni_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>

#include "acquire/layouts/oni_depth.h"
#include "acquire/raw/raw_decode.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

// A file header, then records: magic, type, node, bytes of the header and its fields, bytes of the payload, and where
// the record is that this one undoes: in 4 bytes before version 1.0.1.0, in 8 since.
constexpr std::string_view kFileMagic = "NI10";
constexpr std::uint32_t kRecordMagic = 0x0052494E;  // "NIR\0"
constexpr std::size_t kFileHeader = 24, kShortHeader = 24, kLongHeader = 28;
constexpr std::size_t kMaxFields = 512;  // what we look at; longer ones are tables of the sensor's own
constexpr std::uint32_t kMaxNodes = 64;

enum Record : std::uint32_t {
  kNodeAdded4 = 0x02,  // of versions up to 1.0.0.4
  kIntProperty = 0x03,
  kGeneralProperty = 0x06,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAdded5 = 0x0C,
  kNodeAdded = 0x0D,
  kSeekTable = 0x0E,
};

enum NodeType : std::uint32_t { kDepthNode = 2, kImageNode = 3 };

// Pixels as OpenNI 2 names them, and as OpenNI 1 does.
enum OniPixels : std::uint64_t {
  kDepthMm = 100,
  kDepth100Um = 101,
  kRgb888 = 200,
  kYuv422 = 201,
  kJpegPixels = 204,
  kYuyvPixels = 205
};
enum XnPixels : std::uint64_t { kXnRgb24 = 1, kXnYuv422 = 2, kXnJpeg = 5 };

struct RecordHeader {
  std::uint32_t type = 0, node = 0, payload = 0;
  std::vector<std::byte> fields;  // the first of them
  std::uint64_t payload_at = 0, next_at = 0;
};

std::optional<std::string_view> take_text(ByteReader& reader, std::array<char, kMaxFields>& buffer) {
  const auto length = reader.little_endian<std::uint32_t>();
  const auto bytes = length && *length > 0 && *length <= buffer.size() ? reader.take(*length) : std::nullopt;
  if (!bytes || bytes->back() != std::byte{0}) return std::nullopt;
  std::transform(bytes->begin(), bytes->end(), buffer.begin(), [](std::byte b) { return static_cast<char>(b); });
  return std::string_view(buffer.data(), bytes->size() - 1);
}

OniCoding coding_of(std::uint32_t name) {
  const auto spelt = [](std::string_view s) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(static_cast<unsigned char>(s[i])) << 8 * i;
    return value;
  };
  if (name == spelt("NONE")) return OniCoding::kPlain;
  if (name == spelt("16zP")) return OniCoding::kDepthSteps;
  if (name == spelt("16zT")) return OniCoding::kDepthStepsTable;
  if (name == spelt("JPEG")) return OniCoding::kJpeg;
  return OniCoding::kUnknown;
}

/// The walk through the file, record by record.
class OniWalk {
 public:
  OniWalk(const RandomAccess& file, std::size_t header_bytes, const Limits& limits)
      : file_(file), header_bytes_(header_bytes), limits_(limits) {}

  /// Up to the end, or to what is wrong.
  [[nodiscard]] std::optional<std::string> run() {
    std::uint64_t at = kFileHeader;
    while (true) {
      const auto record = read_record(at);
      if (!record || !take(*record)) return "it is damaged or cut at byte " + std::to_string(at);
      if (record->type == kEnd) return std::nullopt;
      at = record->next_at;
    }
  }

  [[nodiscard]] std::optional<OniStream> take_stream(StreamKind kind) {
    for (auto& [id, stream] : streams_) {
      if (stream.profile.kind == kind && !stream.pictures.empty()) return std::move(stream);
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::optional<RecordHeader> read_record(std::uint64_t at) const {
    std::array<std::byte, kLongHeader> raw{};
    if (at > file_.size() || !file_.read(at, std::span(raw).first(header_bytes_))) return std::nullopt;
    ByteReader reader(raw);
    const auto magic = *reader.little_endian<std::uint32_t>();
    RecordHeader record;
    record.type = *reader.little_endian<std::uint32_t>();
    record.node = *reader.little_endian<std::uint32_t>();
    const auto bytes = *reader.little_endian<std::uint32_t>();  // header and fields
    record.payload = *reader.little_endian<std::uint32_t>();
    if (magic != kRecordMagic || bytes < header_bytes_) return std::nullopt;
    const std::uint64_t left = file_.size() - at;
    if (bytes > left || record.payload > left - bytes) return std::nullopt;
    if (record.payload > 0 && record.type != kNewData && record.type != kSeekTable) return std::nullopt;
    record.fields.resize(std::min<std::size_t>(bytes - header_bytes_, kMaxFields));
    if (!file_.read(at + header_bytes_, record.fields)) return std::nullopt;
    record.payload_at = at + bytes;
    record.next_at = record.payload_at + record.payload;
    return record;
  }

  [[nodiscard]] bool take(const RecordHeader& record) {
    switch (record.type) {
      case kNodeAdded4:
      case kNodeAdded5:
      case kNodeAdded: return add_node(record);
      case kIntProperty:
      case kGeneralProperty: return set_property(record);
      case kNewData: return add_picture(record);
      default: return record.type <= kSeekTable;
    }
  }

  [[nodiscard]] bool add_node(const RecordHeader& record) {
    ByteReader reader(record.fields);
    std::array<char, kMaxFields> buffer{};
    const auto name = take_text(reader, buffer);
    const auto type = reader.little_endian<std::uint32_t>();
    const auto coding = reader.little_endian<std::uint32_t>();
    if (!name || !coding || record.node > kMaxNodes) return false;
    if (*type != kDepthNode && *type != kImageNode) return true;
    OniStream stream;
    stream.profile.kind = *type == kDepthNode ? StreamKind::kDepth : StreamKind::kColour;
    stream.profile.format = *type == kDepthNode ? PixelFormat::kZ16 : PixelFormat::kRgb8;
    stream.coding = coding_of(*coding);
    streams_.insert_or_assign(record.node, std::move(stream));
    return true;
  }

  [[nodiscard]] bool set_property(const RecordHeader& record) {
    const auto found = streams_.find(record.node);
    if (found == streams_.end()) return true;  // of a node whose pictures we do not read
    ByteReader reader(record.fields);
    std::array<char, kMaxFields> buffer{};
    const auto name = take_text(reader, buffer);
    const auto bytes = reader.little_endian<std::uint32_t>();
    if (!name || !bytes) return false;
    if (!found->second.pictures.empty()) return true;  // pictures that it changes will not fit their stream
    return record.type == kIntProperty ? set_number(found->second, *name, reader)
                                       : set_values(found->second, *name, reader);
  }

  [[nodiscard]] static bool set_number(OniStream& stream, std::string_view name, ByteReader& reader) {
    const auto value = reader.little_endian<std::uint64_t>();
    if (!value) return false;
    if (name == "xnMirror") stream.is_mirrored = *value != 0;
    const bool is_depth = stream.profile.kind == StreamKind::kDepth;
    if (name == "oniPixelFormat" && is_depth) {
      stream.is_readable = *value == kDepthMm || *value == kDepth100Um;
      stream.depth_unit_m = *value == kDepth100Um ? 0.0001 : 0.001;
    } else if (name == "oniPixelFormat" || (name == "xnPixelFormat" && !is_depth)) {
      set_colour(stream, *value);
    }
    return true;
  }

  static void set_colour(OniStream& stream, std::uint64_t value) {
    stream.is_readable = true;
    switch (value) {
      case kRgb888:
      case kXnRgb24: stream.profile.format = PixelFormat::kRgb8; break;
      case kYuv422:
      case kXnYuv422: stream.profile.format = PixelFormat::kUyvy; break;
      case kYuyvPixels: stream.profile.format = PixelFormat::kYuyv; break;
      case kJpegPixels:
      case kXnJpeg: stream.profile.format = PixelFormat::kMjpeg; break;
      default: stream.is_readable = false;
    }
  }

  [[nodiscard]] bool set_values(OniStream& stream, std::string_view name, ByteReader& reader) const {
    if (name == "xnMapOutputMode") {
      const auto width = reader.little_endian<std::uint32_t>(), height = reader.little_endian<std::uint32_t>();
      const auto rate = reader.little_endian<std::uint32_t>();
      const auto fits = [](std::uint32_t size) { return size > 0 && size <= 0xFFFF; };
      if (!rate || !fits(*width) || !fits(*height)) return false;
      if (std::int64_t{*width} * *height > limits_.max_image_pixels) return false;
      stream.profile.width = static_cast<int>(*width);
      stream.profile.height = static_cast<int>(*height);
      stream.profile.frames_per_second = *rate;
    } else if (name == "xnFOV") {
      const auto x = reader.little_endian<double>(), y = reader.little_endian<double>();
      stream.view_x_rad = x.value_or(0);
      stream.view_y_rad = y.value_or(0);
    } else if (name == "xnCropping") {
      stream.is_cropped = reader.little_endian<std::uint32_t>().value_or(0) != 0;
    }
    return true;
  }

  [[nodiscard]] bool add_picture(const RecordHeader& record) {
    const auto found = streams_.find(record.node);
    if (found == streams_.end()) return true;
    ByteReader reader(record.fields);
    const auto time_us = reader.little_endian<std::uint64_t>();
    const auto number = reader.little_endian<std::uint32_t>();
    auto& pictures = found->second.pictures;
    constexpr std::uint64_t kLongest_us = 1ull << 52;  // a century; as nanoseconds it still fits
    if (!number || *time_us > kLongest_us || pictures.size() >= limits_.max_frames) return false;
    pictures.push_back({record.payload_at, record.payload, *number, *time_us});
    return true;
  }

  const RandomAccess& file_;
  std::size_t header_bytes_;
  const Limits& limits_;
  std::map<std::uint32_t, OniStream> streams_;
};

/// Bytes of a record's header; nothing: a version that we do not know.
std::optional<std::size_t> header_bytes_of(const RandomAccess& file) {
  std::array<std::byte, kFileHeader> raw{};
  if (!file.read(0, raw)) return std::nullopt;
  ByteReader reader(raw);
  (void)reader.take(kFileMagic.size());
  const auto major = *reader.little_endian<std::uint8_t>(), minor = *reader.little_endian<std::uint8_t>();
  const auto maintenance = *reader.little_endian<std::uint16_t>();
  if (major != 1 || minor != 0 || maintenance > 1) return std::nullopt;
  return maintenance == 0 ? kShortHeader : kLongHeader;
}

/// As RGB with the left side on the left.
Result<RawFrame> unmirror_colour(RawFrame frame, const Limits& limits) {
  const auto image = decode_raw_colour(frame, limits);
  if (!image) return image.error();
  std::vector<std::byte> rgb;
  rgb.reserve(3 * image->size());
  for (const Rgb8& pixel : image->pixels())
    rgb.insert(rgb.end(), {std::byte{pixel.r}, std::byte{pixel.g}, std::byte{pixel.b}});
  mirror(rgb, static_cast<std::size_t>(frame.profile.width), 3);
  frame.profile.format = PixelFormat::kRgb8;
  frame.bytes = std::make_shared<const std::vector<std::byte>>(std::move(rgb));
  return frame;
}

}  // namespace

bool is_oni(const RandomAccess& file) {
  std::array<std::byte, kFileMagic.size()> first{};
  return file.read(0, first) && std::equal(first.begin(), first.end(), kFileMagic.begin(),
                                           [](std::byte b, char c) { return b == static_cast<std::byte>(c); });
}

Result<OniFile> OniFile::open(std::unique_ptr<RandomAccess> file, const Limits& limits) {
  OniFile oni(std::move(file), limits);
  const auto refuse = [](std::string what) { return Error{ErrorCode::kInput, std::move(what)}; };
  if (!is_oni(*oni.file_)) return refuse("no recording of OpenNI");
  const auto header_bytes = header_bytes_of(*oni.file_);
  if (!header_bytes) return refuse("a recording of OpenNI of a version that is not known (known: 1.0.0 and 1.0.1)");
  OniWalk walk(*oni.file_, *header_bytes, limits);
  oni.fault_ = walk.run();
  auto depth = walk.take_stream(StreamKind::kDepth);
  if (!depth) {
    return refuse("a recording of OpenNI without one depth picture" + (oni.fault_ ? ": " + *oni.fault_ : ""));
  }
  if (!depth->is_readable || depth->coding == OniCoding::kUnknown || depth->coding == OniCoding::kJpeg) {
    return refuse("its depth is of a kind that is not read (expected millimetres or 0.1 mm, plain, 16zP or 16zT)");
  }
  if (depth->is_cropped) return refuse("its depth pictures are cropped, which is not read");
  if (depth->profile.width == 0) return refuse("the size of its depth pictures is missing");
  oni.depth_ = *std::move(depth);
  auto colour = walk.take_stream(StreamKind::kColour);
  const bool is_colour_good = colour && colour->is_readable && !colour->is_cropped && colour->profile.width > 0;
  if (is_colour_good && (colour->coding == OniCoding::kPlain || colour->coding == OniCoding::kJpeg)) {
    if (colour->coding == OniCoding::kJpeg) colour->profile.format = PixelFormat::kMjpeg;
    oni.colour_ = std::move(colour);
  }
  return oni;
}

Result<std::vector<std::byte>> OniFile::read_pixels(const OniStream& stream, const OniPicture& picture) const {
  if (picture.bytes > limits_.max_image_bytes) return Error{ErrorCode::kInput, "the picture is beyond the limits"};
  std::vector<std::byte> packed(picture.bytes);
  if (!file_->read(picture.offset, packed)) return Error{ErrorCode::kInput, "the picture cannot be read"};
  if (stream.coding == OniCoding::kPlain || stream.coding == OniCoding::kJpeg) return packed;
  const auto pixels = static_cast<std::size_t>(stream.profile.width) * static_cast<std::size_t>(stream.profile.height);
  const auto values = unpack_oni_depth(packed, stream.coding == OniCoding::kDepthStepsTable, pixels);
  if (!values) return values.error();
  std::vector<std::byte> bytes;
  bytes.reserve(2 * pixels);
  for (const std::uint16_t value : *values) {
    bytes.insert(bytes.end(), {static_cast<std::byte>(value & 0xFF), static_cast<std::byte>(value >> 8)});
  }
  return bytes;
}

Result<RawFrame> OniFile::read(StreamKind kind, std::size_t index) const {
  const OniStream& stream = kind == StreamKind::kDepth ? depth_ : *colour_;
  const OniPicture& picture = stream.pictures[index];
  auto bytes = read_pixels(stream, picture);
  if (!bytes) return bytes.error();
  const bool is_depth = kind == StreamKind::kDepth;
  if (is_depth && stream.is_mirrored) mirror(*bytes, static_cast<std::size_t>(stream.profile.width), 2);
  const auto time_ns = static_cast<std::int64_t>(picture.time_us) * 1000;
  RawFrame frame{stream.profile, picture.number, time_ns, time_ns,
                 std::make_shared<const std::vector<std::byte>>(*std::move(bytes))};
  if (!is_depth && stream.is_mirrored) return unmirror_colour(std::move(frame), limits_);
  return frame;
}

}  // namespace scanknit
