#include "acquire/usb/realsense_tables.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/files/byte_reader.h"
#include "core/files/crc32.h"

// Layouts after librealsense (Apache-2.0), src/ds/d400/d400-private.h and src/hw-monitor.h; numbers are little endian.
namespace scanknit {
namespace {

constexpr std::uint16_t kMagic = 0xCDAB;
constexpr double kMetresPerMm = 0.001;

Error bad(const std::string& what) {
  return {ErrorCode::kDevice, what, "RealSense calibration"};
}

void put(std::vector<std::byte>& bytes, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xFF));
}

/// What follows the table's header {u16 version, u16 type, u32 size, u32 parameter, u32 checksum}, checked.
Result<ByteReader> open_table(std::span<const std::byte> table, std::uint32_t id) {
  const std::string name = "table " + std::to_string(id);
  ByteReader reader(table);
  (void)reader.big_endian<std::uint16_t>();
  const auto type = reader.little_endian<std::uint16_t>();
  const auto size = reader.little_endian<std::uint32_t>();
  (void)reader.little_endian<std::uint32_t>();
  const auto checksum = reader.little_endian<std::uint32_t>();
  if (!checksum) return bad(name + " is cut short: " + std::to_string(table.size()) + " bytes");
  if (*type != id) return bad("asked for " + name + ", got table " + std::to_string(*type));
  const auto body = reader.take(*size);
  if (!body) {
    return bad(name + " is cut short: it says " + std::to_string(*size) + " bytes, " +
               std::to_string(reader.remaining()) + " came");
  }
  if (crc32(*body) != *checksum) return bad(name + " has a wrong checksum");
  return ByteReader(*body);
}

std::optional<double> take_float(ByteReader& reader) {
  const auto value = reader.little_endian<float>();
  if (!value || !std::isfinite(*value)) return std::nullopt;
  return static_cast<double>(*value);
}

template <std::size_t N>
std::optional<std::array<double, N>> take_floats(ByteReader& reader) {
  std::array<double, N> values{};
  for (double& value : values) {
    const auto next = take_float(reader);
    if (!next) return std::nullopt;
    value = *next;
  }
  return values;
}

bool is_sensible(const CameraIntrinsics& camera) {
  return camera.is_valid() && camera.fx > 1 && camera.fy > 1 && camera.cx > 0 && camera.cy > 0 &&
         camera.cx < camera.width && camera.cy < camera.height;
}

}  // namespace

std::vector<std::byte> encode_command(RealsenseOpcode opcode, std::uint32_t parameter) {
  constexpr std::uint32_t kBytesAfterMagic = 20;  // opcode and four parameters
  std::vector<std::byte> bytes;
  put(bytes, kBytesAfterMagic, 2);
  put(bytes, kMagic, 2);
  put(bytes, static_cast<std::uint32_t>(opcode), 4);
  put(bytes, parameter, 4);
  bytes.resize(bytes.size() + 12);
  return bytes;
}

Result<std::span<const std::byte>> decode_reply(RealsenseOpcode opcode, std::span<const std::byte> reply) {
  ByteReader reader(reply);
  const auto echo = reader.little_endian<std::uint32_t>();
  if (!echo) return bad("the camera's answer has " + std::to_string(reply.size()) + " bytes, expected 4 or more");
  if (*echo != static_cast<std::uint32_t>(opcode)) {
    return bad("the camera refused command " + std::to_string(static_cast<std::uint32_t>(opcode)) + " with code " +
               std::to_string(static_cast<std::int32_t>(*echo)));
  }
  return *reader.take(reader.remaining());
}

Result<RealsenseIdentity> parse_identity(std::span<const std::byte> data) {
  ByteReader reader(data);
  const auto before = reader.take(12);
  const auto version = reader.take(4);
  const auto between = reader.take(32);
  const auto serial = reader.take(6);
  if (!before || !version || !between || !serial)
    return bad("the camera's identity is cut short: " + std::to_string(data.size()) + " bytes");
  RealsenseIdentity identity;
  for (std::size_t i = 4; i-- > 0;) {
    identity.firmware += std::to_string(std::to_integer<int>((*version)[i])) + (i > 0 ? "." : "");
  }
  for (const std::byte byte : *serial) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", std::to_integer<unsigned>(byte));
    identity.serial += digits.data();
  }
  return identity;
}

Result<CameraIntrinsics> parse_depth_table(std::span<const std::byte> table, int width, int height) {
  struct Size {
    int width, height;
  };
  // The table's own order; entries 10 and 11 are unused.
  constexpr Size kSizes[] = {{1920, 1080}, {1280, 720}, {640, 480}, {848, 480}, {640, 360}, {424, 240}, {320, 240},
                             {480, 270},   {1280, 800}, {960, 540}, {0, 0},     {0, 0},     {640, 400}};
  auto body = open_table(table, kDepthTable);
  if (!body) return body.error();
  // Two camera matrices, two rotations, baseline, model, 88 reserved bytes: 240 bytes.
  if (!body->take(240)) return bad("the depth table is cut short");
  for (const Size& size : kSizes) {
    const auto values = take_floats<4>(*body);
    if (size.width != width || size.height != height) continue;
    if (!values) break;
    const CameraIntrinsics camera{width, height, (*values)[0], (*values)[1], (*values)[2], (*values)[3]};
    if (is_sensible(camera)) return camera;
    break;
  }
  return bad("the depth table has no sensible values for " + std::to_string(width) + "x" + std::to_string(height));
}

Result<double> parse_baseline(std::span<const std::byte> table) {
  constexpr double kShortest_m = 0.005, kLongest_m = 0.5;  // a D405 has 18 mm, a D455 95 mm
  auto body = open_table(table, kDepthTable);
  if (!body) return body.error();
  const bool has_matrices = body->take(144).has_value();  // two camera matrices, two rotations
  const auto baseline_mm = has_matrices ? take_float(*body) : std::nullopt;
  if (!baseline_mm) return bad("the depth table is cut short");
  // It is where the left camera is, seen from the right one: below zero.
  const double baseline_m = kMetresPerMm * std::abs(*baseline_mm);
  if (baseline_m >= kShortest_m && baseline_m <= kLongest_m) return baseline_m;
  return bad("the depth table has no sensible baseline: " + std::to_string(*baseline_mm) + " mm");
}

Result<double> parse_depth_unit(std::span<const std::byte> data) {
  constexpr std::uint32_t kFinest_um = 1, kCoarsest_um = 10'000;
  const auto unit_um = ByteReader(data).little_endian<std::uint32_t>();
  if (!unit_um) return bad("the camera's depth unit is cut short: " + std::to_string(data.size()) + " bytes");
  if (*unit_um < kFinest_um || *unit_um > kCoarsest_um) {
    return bad("the camera's depth unit is " + std::to_string(*unit_um) + " micrometres, expected 1 to 10000");
  }
  return *unit_um / 1e6;
}

Result<RealsenseColour> parse_colour_table(std::span<const std::byte> table, int width, int height) {
  auto body = open_table(table, kColourTable);
  if (!body) return body.error();
  const auto k = take_floats<9>(*body);  // by columns, of a picture from -1 to 1
  const auto distortion = take_floats<5>(*body);
  const auto before_size = body->take(12 + 12 + 48);  // rotation, translation and projection before rectification
  const auto calibrated_width = body->little_endian<std::uint16_t>();
  const auto calibrated_height = body->little_endian<std::uint16_t>();
  const auto before_rotation = body->take(36);
  const auto rotation = take_floats<9>(*body);  // by columns
  const auto translation_mm = take_floats<3>(*body);
  const bool is_whole = k && distortion && before_size && calibrated_height && before_rotation && rotation;
  if (!is_whole || !translation_mm || width < 1 || height < 1) {
    return bad("the colour table is cut short or has values that are no numbers");
  }
  // A picture of another shape than the calibrated one is cut from it: what it keeps spans more of it.
  const bool has_size = *calibrated_width > 0 && *calibrated_height > 0;
  const double calibrated_aspect = has_size ? static_cast<double>(*calibrated_height) / *calibrated_width : 9.0 / 16.0;
  const double stretch = static_cast<double>(height) / width / calibrated_aspect;
  const double sx = stretch < 1 ? 1 : stretch;
  const double sy = stretch < 1 ? 1 / stretch : 1;
  RealsenseColour colour;
  colour.camera.intrinsics = {width,
                              height,
                              (*k)[0] * sx * width / 2,
                              (*k)[4] * sy * height / 2,
                              (1 + (*k)[6] * sx) * width / 2,
                              (1 + (*k)[7] * sy) * height / 2};
  colour.camera.distortion = *distortion;
  if (!is_sensible(colour.camera.intrinsics)) return bad("the colour table has no sensible values");

  // The table leads from colour to depth, and its translation points the other way.
  Eigen::Matrix4d depth_colour = Eigen::Matrix4d::Identity();
  depth_colour.topLeftCorner<3, 3>() = Eigen::Map<const Eigen::Matrix3d>(rotation->data());
  depth_colour.topRightCorner<3, 1>() = -kMetresPerMm * Eigen::Map<const Eigen::Vector3d>(translation_mm->data());
  const auto T_depth_colour = pose_from_matrix(depth_colour);
  if (!T_depth_colour) return bad("the colour table's rotation is none: " + T_depth_colour.error().message);
  colour.T_colour_depth = T_depth_colour->inverse();
  return colour;
}

}  // namespace scanknit
