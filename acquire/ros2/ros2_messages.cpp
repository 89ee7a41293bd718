#include "acquire/ros2/ros2_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

constexpr std::uint32_t kMaxTransforms = 1000;
constexpr std::uint32_t kMaxCoefficients = 64;
constexpr std::uint32_t kMaxSide = 1u << 16;

Error refuse(const std::string& what) {
  return {ErrorCode::kInput, what};
}

Error truncated(const char* type) {
  return refuse(std::string("a message of ") + type + " is truncated, or not as its type is written");
}

std::string without_slash(std::string frame) {
  if (frame.starts_with('/')) frame.erase(0, 1);
  return frame;
}

/// geometry_msgs/Transform and Pose: a position, then a quaternion x y z w. Nothing: truncated.
std::optional<Result<Pose>> take_pose(CdrReader& reader) {
  std::array<double, 7> v{};
  if (!reader.numbers(v)) return std::nullopt;
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  constexpr double kTolerance = 0.01;
  const bool is_rigid = std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]) &&
                        std::abs(q.norm() - 1) <= kTolerance;  // false for NaN, too
  if (!is_rigid) return refuse("the pose is not finite, or its quaternion is not of length 1");
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

struct Lens {
  std::string model;
  std::vector<double> coefficients;
};

std::optional<Lens> take_lens(CdrReader& reader) {
  auto model = reader.text();
  const auto count = reader.number<std::uint32_t>();
  if (!model || !count || *count > kMaxCoefficients) return std::nullopt;
  Lens lens{*std::move(model), std::vector<double>(*count)};
  return reader.numbers(lens.coefficients) ? std::optional(std::move(lens)) : std::nullopt;
}

// "plumb_bob" has five coefficients, "rational_polynomial" eight, both in OpenCV's order; "equidistant" four.
void set_distortion(const Lens& lens, Ros2Camera& camera) {
  if (lens.model == "equidistant" && lens.coefficients.size() <= 4) {
    camera.fisheye.emplace();
    std::copy(lens.coefficients.begin(), lens.coefficients.end(), camera.fisheye->k.begin());
    return;
  }
  const std::size_t held = lens.model == "plumb_bob" ? 5 : lens.model == "rational_polynomial" ? 8 : 0;
  for (std::size_t i = 0; i < lens.coefficients.size(); ++i) {
    if (i < held) {
      camera.distortion[i] = lens.coefficients[i];
    } else {
      camera.has_other_lens |= lens.coefficients[i] != 0;
    }
  }
}

/// Binning and region of interest; false: they are not those of a whole picture. Nothing: truncated.
std::optional<bool> take_is_whole(CdrReader& reader) {
  std::array<std::uint32_t, 4> values{};  // binning in x and y, the region's place
  if (!reader.numbers(values)) return std::nullopt;
  return values[0] <= 1 && values[1] <= 1 && values[2] == 0 && values[3] == 0;
}

}  // namespace

std::optional<Ros2Header> take_header(CdrReader& reader) {
  if (reader.is_ros1() && !reader.number<std::uint32_t>()) return std::nullopt;  // the message's number
  const auto seconds = reader.number<std::int32_t>();
  const auto nanoseconds = reader.number<std::uint32_t>();
  auto frame = reader.text();
  if (!seconds || !nanoseconds || !frame) return std::nullopt;
  return Ros2Header{std::int64_t{*seconds} * 1'000'000'000 + *nanoseconds, without_slash(*std::move(frame))};
}

Result<Ros2Image> parse_image(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  if (!header) return truncated("sensor_msgs/Image");
  const auto height = reader->number<std::uint32_t>();
  const auto width = reader->number<std::uint32_t>();
  auto encoding = reader->text();
  const auto is_big_endian = reader->number<std::uint8_t>();
  const auto step = reader->number<std::uint32_t>();
  const auto data = reader->sequence();
  if (!height || !width || !encoding || !is_big_endian || !step || !data) return truncated("sensor_msgs/Image");
  return Ros2Image{*std::move(header), *width, *height, *std::move(encoding), *is_big_endian != 0, *step, *data};
}

Result<Ros2CompressedImage> parse_compressed_image(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  auto format = header ? reader->text() : std::nullopt;
  const auto data = format ? reader->sequence() : std::nullopt;
  if (!data) return truncated("sensor_msgs/CompressedImage");
  return Ros2CompressedImage{*std::move(header), *std::move(format), *data};
}

Result<Ros2Camera> parse_camera_info(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  const auto header = reader ? take_header(*reader) : std::nullopt;
  if (!header) return truncated("sensor_msgs/CameraInfo");
  const auto height = reader->number<std::uint32_t>();
  const auto width = reader->number<std::uint32_t>();
  const auto lens = take_lens(*reader);
  std::array<double, 9> k{}, r{};
  std::array<double, 12> p{};
  const bool has_matrices = lens && reader->numbers(k) && reader->numbers(r) && reader->numbers(p);
  const auto is_whole = has_matrices ? take_is_whole(*reader) : std::nullopt;
  if (!height || !width || !is_whole) return truncated("sensor_msgs/CameraInfo");
  if (!*is_whole) return refuse("the camera has binning or a region of interest, which are not read");
  if (*width > kMaxSide || *height > kMaxSide) return refuse("the camera's picture is too large");
  Ros2Camera camera;
  camera.raw = {static_cast<int>(*width), static_cast<int>(*height), k[0], k[4], k[2], k[5]};
  camera.rectified = {static_cast<int>(*width), static_cast<int>(*height), p[0], p[5], p[2], p[6]};
  set_distortion(*lens, camera);
  if (!camera.rectified.is_valid()) camera.rectified = camera.raw;
  const bool is_finite = std::all_of(lens->coefficients.begin(), lens->coefficients.end(),
                                     [](double coefficient) { return std::isfinite(coefficient); });
  if (!camera.raw.is_valid() || !is_finite) return refuse("the camera is not calibrated: its matrix K is not usable");
  return camera;
}

Result<std::vector<Ros2Transform>> parse_transforms(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  const auto count = reader ? reader->number<std::uint32_t>() : std::nullopt;
  if (!count) return truncated("tf2_msgs/TFMessage");
  if (*count > kMaxTransforms) return refuse("a message of tf2_msgs/TFMessage has more than 1000 transforms");
  std::vector<Ros2Transform> transforms;
  for (std::uint32_t i = 0; i < *count; ++i) {
    auto header = take_header(*reader);
    auto child = header ? reader->text() : std::nullopt;
    auto pose = child ? take_pose(*reader) : std::nullopt;
    if (!pose) return truncated("tf2_msgs/TFMessage");
    transforms.push_back(
        {header->stamp_ns, std::move(header->frame), without_slash(*std::move(child)), *std::move(pose)});
  }
  return transforms;
}

Result<Ros2Transform> parse_odometry(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  auto child = header ? reader->text() : std::nullopt;
  auto pose = child ? take_pose(*reader) : std::nullopt;
  if (!pose) return truncated("nav_msgs/Odometry");
  return Ros2Transform{header->stamp_ns, std::move(header->frame), without_slash(*std::move(child)), *std::move(pose)};
}

Result<Ros2Transform> parse_pose_stamped(const RosMessage& message) {
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  auto pose = header ? take_pose(*reader) : std::nullopt;
  if (!pose) return truncated("geometry_msgs/PoseStamped");
  return Ros2Transform{header->stamp_ns, std::move(header->frame), {}, *std::move(pose)};
}

}  // namespace scanknit
