// Recordings of RealSense Viewer: a bag with topics such as /device_0/sensor_0/Depth_0/image/data.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/ros_bag.h"
#include "acquire/raw/raw_recording.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

constexpr double kUsualUnit_m = 0.001;
constexpr std::size_t kMaxCoefficients = 64;

// The little that ROS messages are made of.
std::optional<std::string> take_text(ByteReader& reader) {
  const auto length = reader.little_endian<std::uint32_t>();
  const auto bytes = length ? reader.take(*length) : std::nullopt;
  if (!bytes) return std::nullopt;
  std::string text(bytes->size(), '\0');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>((*bytes)[i]);
  return text;
}

// std_msgs/Header: a counter, a time, the name of a frame. Its time is of the sensor's own clock, and each sensor may
// have another one: the bag's time is the one that both streams share.
std::optional<std::uint32_t> take_header(ByteReader& reader) {
  const auto counter = reader.little_endian<std::uint32_t>();
  const auto time = reader.little_endian<std::uint64_t>();
  const auto frame = take_text(reader);
  return time && frame ? counter : std::nullopt;
}

struct EncodingName {
  std::string_view name;
  PixelFormat format;
  std::size_t bytes_per_pixel;
};
constexpr EncodingName kEncodings[] = {{"mono16", PixelFormat::kZ16, 2},  {"16UC1", PixelFormat::kZ16, 2},
                                       {"rgb8", PixelFormat::kRgb8, 3},   {"8UC3", PixelFormat::kRgb8, 3},
                                       {"bgr8", PixelFormat::kBgr8, 3},   {"yuyv", PixelFormat::kYuyv, 2},
                                       {"yuv422", PixelFormat::kUyvy, 2}, {"uyvy", PixelFormat::kUyvy, 2}};

// sensor_msgs/Image.
Result<RawFrame> parse_image(std::span<const std::byte> message, StreamKind kind, const Limits& limits) {
  const Error truncated{ErrorCode::kInput, "the picture's message is truncated"};
  ByteReader reader(message);
  const auto counter = take_header(reader);
  const auto height = reader.little_endian<std::uint32_t>();
  const auto width = reader.little_endian<std::uint32_t>();
  const auto encoding = take_text(reader);
  const auto is_big_endian = reader.little_endian<std::uint8_t>();
  const auto step = reader.little_endian<std::uint32_t>();
  const auto size = reader.little_endian<std::uint32_t>();
  if (!counter || !height || !width || !encoding || !is_big_endian || !step || !size) return truncated;
  const auto* known = std::find_if(std::begin(kEncodings), std::end(kEncodings),
                                   [&](const EncodingName& name) { return name.name == *encoding; });
  const bool is_depth = kind == StreamKind::kDepth;
  if (known == std::end(kEncodings) || (known->format == PixelFormat::kZ16) != is_depth || *is_big_endian != 0) {
    return Error{ErrorCode::kInput, "pictures of encoding '" + *encoding + "' are not read here"};
  }
  const auto pixels = checked_mul<std::uint64_t>(*width, *height);
  if (!pixels || *pixels == 0 || *pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return Error{ErrorCode::kInput,
                 "a picture of " + std::to_string(*width) + " x " + std::to_string(*height) + " pixels is not read"};
  }
  const std::size_t row = *width * known->bytes_per_pixel;
  const auto data = reader.take(*size);
  if (!data) return truncated;
  if (*step < row || std::uint64_t{*step} * *height != *size) {
    return Error{ErrorCode::kInput, "the picture contradicts itself about its size"};
  }
  std::vector<std::byte> bytes;
  bytes.reserve(row * *height);
  for (std::uint32_t y = 0; y < *height; ++y) {
    const auto line = data->subspan(std::size_t{y} * *step, row);
    bytes.insert(bytes.end(), line.begin(), line.end());
  }
  RawFrame frame;
  frame.profile = {kind, known->format, static_cast<int>(*width), static_cast<int>(*height), 0};
  frame.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  return frame;
}

// sensor_msgs/CameraInfo, as far as the matrix K. `has_other_lens`: a distortion that is not Brown's.
std::optional<CameraModel> parse_camera_info(std::span<const std::byte> message, bool& has_other_lens) {
  ByteReader reader(message);
  const auto counter = take_header(reader);
  const auto height = reader.little_endian<std::uint32_t>();
  const auto width = reader.little_endian<std::uint32_t>();
  const auto lens = take_text(reader);
  const auto count = reader.little_endian<std::uint32_t>();
  constexpr std::uint32_t kMaxSide = 1u << 16;
  if (!counter || !height || !width || !lens || !count) return std::nullopt;
  if (*width > kMaxSide || *height > kMaxSide || *count > kMaxCoefficients) return std::nullopt;
  CameraModel camera;
  bool bends = false;
  for (std::uint32_t i = 0; i < *count; ++i) {
    const auto coefficient = reader.little_endian<double>();
    if (!coefficient || !std::isfinite(*coefficient)) return std::nullopt;
    bends |= *coefficient != 0;
    if (i < camera.distortion.size()) camera.distortion[i] = *coefficient;
  }
  if (bends && *lens != "Brown Conrady" && *lens != "plumb_bob") {
    has_other_lens = true;
    camera.distortion = {};
  }
  std::array<double, 9> k{};
  for (double& value : k) {
    const auto entry = reader.little_endian<double>();
    if (!entry) return std::nullopt;
    value = *entry;
  }
  camera.intrinsics = {static_cast<int>(*width), static_cast<int>(*height), k[0], k[4], k[2], k[5]};
  return camera.intrinsics.is_valid() ? std::optional(camera) : std::nullopt;
}

// geometry_msgs/Transform: from the device's point of reference to the stream's camera.
std::optional<Pose> parse_transform(std::span<const std::byte> message) {
  ByteReader reader(message);
  std::array<double, 7> values{};
  for (double& value : values) {
    const auto number = reader.little_endian<double>();
    if (!number || !std::isfinite(*number)) return std::nullopt;
    value = *number;
  }
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  if (std::abs(rotation.norm() - 1) > 0.01) return std::nullopt;
  Pose pose(Eigen::Translation3d(values[0], values[1], values[2]));
  pose.rotate(rotation.normalized());
  return pose;
}

struct Stream {
  std::vector<BagMessage> pictures;
  std::optional<CameraModel> camera;
  std::optional<Pose> T_camera_device;
  double frames_per_second = 0;
};

struct BagRecording {
  RosBag bag;
  Limits limits = {};
  Stream depth = {}, colour = {};
  double unit_m = kUsualUnit_m;
  std::string device = {}, serial = {};
  bool has_other_lens = false;

  [[nodiscard]] Stream& stream(StreamKind kind) { return kind == StreamKind::kDepth ? depth : colour; }
};

// "/device_0/sensor_1/Color_0/image/data": the part after the stream's name.
std::optional<std::string_view> after_stream(std::string_view topic, std::string_view stream) {
  const std::size_t at = topic.find(stream);
  return at == std::string_view::npos ? std::nullopt : std::optional(topic.substr(at + stream.size()));
}

void note_stream(BagRecording& file, Stream& stream, std::string_view what, const BagMessage& message) {
  if (what == "/image/data") {
    stream.pictures.push_back(message);
    return;
  }
  const bool is_wanted = what == "/info/camera_info" || what == "/tf/0" || what == "/info";
  if (!is_wanted) return;
  const auto data = file.bag.read(message);
  if (!data) return;
  if (what == "/info/camera_info" && !stream.camera) stream.camera = parse_camera_info(*data, file.has_other_lens);
  if (what == "/tf/0" && !stream.T_camera_device) stream.T_camera_device = parse_transform(*data);
  if (what == "/info") stream.frames_per_second = ByteReader(*data).little_endian<std::uint32_t>().value_or(0);
}

// Names and units of the device.
void note_device(BagRecording& file, std::string_view topic, const BagMessage& message) {
  const bool is_unit = topic.find("/option/Depth Units/value") != std::string_view::npos ||
                       topic.find("/option/Depth_Units/value") != std::string_view::npos;
  const bool is_info = topic == "/device_0/info";
  if (!is_unit && !is_info) return;
  const auto data = file.bag.read(message);
  if (!data) return;
  ByteReader reader(*data);
  if (is_unit) {
    const float unit_m = reader.little_endian<float>().value_or(0);
    // A float's digits: 0.001 is meant, not 0.0010000000475.
    if (unit_m >= 1e-7F && unit_m <= 1) file.unit_m = std::round(static_cast<double>(unit_m) * 1e7) / 1e7;
    return;
  }
  const auto key = take_text(reader);
  const auto value = take_text(reader);
  if (key && value && *key == "Name") file.device = *value;
  if (key && value && *key == "Serial Number") file.serial = *value;
}

void sort_messages(BagRecording& file) {
  const std::vector<BagConnection> connections = file.bag.connections();
  std::map<std::uint32_t, std::string> topics;
  for (const BagConnection& connection : connections) topics[connection.id] = connection.topic;
  const std::vector<BagMessage> messages = file.bag.messages();
  for (const BagMessage& message : messages) {
    const std::string& topic = topics[message.connection];
    if (const auto depth = after_stream(topic, "/Depth_0")) {
      note_stream(file, file.depth, *depth, message);
    } else if (const auto colour = after_stream(topic, "/Color_0")) {
      note_stream(file, file.colour, *colour, message);
    } else {
      note_device(file, topic, message);
    }
  }
}

std::vector<RawStamp> stamps_of(const Stream& stream) {
  std::vector<RawStamp> stamps;
  for (const BagMessage& message : stream.pictures) stamps.push_back({stamps.size(), message.time_ns});
  return stamps;
}

RawCalibration calibration_of(const BagRecording& file) {
  RawCalibration calibration;
  if (file.depth.camera) calibration.depth = *file.depth.camera;
  if (file.colour.camera) calibration.colour = *file.colour.camera;
  if (file.depth.T_camera_device && file.colour.T_camera_device) {
    calibration.T_colour_depth = *file.colour.T_camera_device * file.depth.T_camera_device->inverse();
  }
  calibration.depth_unit_m = file.unit_m;
  calibration.source = "the bag's";
  calibration.device = file.device;
  calibration.serial = file.serial;
  return calibration;
}

Result<RawFrame> read_picture(BagRecording& file, StreamKind kind, std::size_t index) {
  const Stream& stream = file.stream(kind);
  const auto message = file.bag.read(stream.pictures[index]);
  if (!message) return message.error();
  auto frame = parse_image(*message, kind, file.limits);
  if (!frame) return frame;
  frame->profile.frames_per_second = stream.frames_per_second;
  frame->sequence = index;
  frame->device_ns = frame->host_ns = stream.pictures[index].time_ns;
  return frame;
}

// RealSense's topics begin with their device.
bool is_of_others(const RosBag& bag) {
  const auto& connections = bag.connections();
  return !connections.empty() && std::none_of(connections.begin(), connections.end(), [](const auto& connection) {
    return connection.topic.starts_with("/device_");
  });
}

}  // namespace

bool fits_realsense_bag(const RandomAccess& file) {
  return is_ros_bag(file);
}

bool fits_ros1(const RandomAccess& file) {
  return is_ros_bag(file);
}

Result<Recording> index_ros1(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                             const AcquireConfig& config) {
  auto bag = RosBag::open(std::move(file), config.limits);
  if (!bag) return located(bag.error(), path);
  return index_bag(messages_of_ros1(*std::move(bag)), path, config);
}

Result<Recording> index_realsense_bag(std::unique_ptr<RandomAccess> access, const std::filesystem::path& path,
                                      const AcquireConfig& config) {
  auto bag = RosBag::open(std::move(access), config.limits);
  if (!bag) return located(bag.error(), path);
  if (is_of_others(*bag)) return index_bag(messages_of_ros1(*std::move(bag)), path, config);
  const auto file = std::make_shared<BagRecording>(BagRecording{*std::move(bag), config.limits});
  sort_messages(*file);
  const std::optional<std::string>& fault = file->bag.fault();
  if (file->depth.pictures.empty()) {
    const std::string depth = "depth pictures of a RealSense (topics .../Depth_0/image/data)";
    return Error{ErrorCode::kInput,
                 fault ? "the bag is torn, and no " + depth + " can be read from it: " + *fault +
                             "; copy it again where the original is whole, else record anew"
                       : "a bag without " + depth,
                 path.string()};
  }
  RawRecording raw{.format = "realsense-bag", .file = path};
  raw.calibration = calibration_of(*file);
  raw.depth = stamps_of(file->depth);
  raw.colour = stamps_of(file->colour);
  if (fault) raw.warnings.push_back("the bag is torn: " + *fault + ". What is whole in it is read");
  if (!raw.colour.empty() && !(file->depth.T_camera_device && file->colour.T_camera_device)) {
    raw.warnings.emplace_back("the bag does not say where its colour camera is: it is taken to be where depth's is");
  }
  if (file->has_other_lens) raw.warnings.emplace_back("a lens is of a kind that is not known, and is not straightened");
  raw.read = [file](StreamKind kind, std::size_t index) { return read_picture(*file, kind, index); };
  return index_raw_recording(std::move(raw), config);
}

}  // namespace scanknit
