#include "acquire/ros2/ros2_cloud.h"

#include <Eigen/Core>
#include <algorithm>
#include <utility>
#include <vector>

#include "acquire/pcl/cloud_picture.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kMostFields = 100;
constexpr std::uint8_t kUint32 = 6, kFloat32 = 7;  // sensor_msgs/PointField
constexpr std::size_t kFieldBytes = 4;

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t type = 0;
  std::uint32_t count = 0;
};

struct Cloud {
  Ros2Header header;
  std::uint32_t width = 0, height = 0;
  std::vector<CloudField> fields;
  bool is_big_endian = false;
  std::uint32_t point_step = 0, row_step = 0;  // bytes
  std::span<const std::byte> data;

  [[nodiscard]] const CloudField* find(std::string_view name, bool is_any_type = false) const {
    const auto found = std::find_if(fields.begin(), fields.end(), [&](const CloudField& field) {
      const bool is_read = field.type == kFloat32 || (is_any_type && field.type == kUint32);
      const bool fits = point_step >= kFieldBytes && field.offset <= point_step - kFieldBytes;
      return field.name == name && is_read && field.count <= 1 && fits;
    });
    return found == fields.end() ? nullptr : &*found;
  }
  [[nodiscard]] const CloudField* find_colour() const {
    const CloudField* rgb = find("rgb", true);
    return rgb != nullptr ? rgb : find("rgba", true);
  }
};

Error refuse_cloud(const std::string& what) {
  return {ErrorCode::kInput, what};
}

std::optional<std::vector<CloudField>> take_fields(CdrReader& reader) {
  const auto count = reader.number<std::uint32_t>();
  if (!count || *count > kMostFields) return std::nullopt;
  std::vector<CloudField> fields;
  for (std::uint32_t i = 0; i < *count; ++i) {
    auto name = reader.text();
    const auto offset = reader.number<std::uint32_t>();
    const auto type = reader.number<std::uint8_t>();
    const auto elements = reader.number<std::uint32_t>();
    if (!name || !offset || !type || !elements) return std::nullopt;
    fields.push_back({*std::move(name), *offset, *type, *elements});
  }
  return fields;
}

Result<Cloud> parse_cloud(const RosMessage& message) {
  const Error truncated =
      refuse_cloud("a message of sensor_msgs/PointCloud2 is truncated, or not as its type is written");
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  if (!header) return truncated;
  const auto height = reader->number<std::uint32_t>();
  const auto width = reader->number<std::uint32_t>();
  auto fields = take_fields(*reader);
  if (!height || !width || !fields) return truncated;
  const auto is_big_endian = reader->number<std::uint8_t>();
  const auto point_step = reader->number<std::uint32_t>();
  const auto row_step = reader->number<std::uint32_t>();
  const auto data = reader->sequence();
  if (!is_big_endian || !point_step || !row_step || !data) return truncated;
  Cloud cloud{*std::move(header),  *width,      *height,   *std::move(fields),
              *is_big_endian != 0, *point_step, *row_step, *data};
  if (cloud.find("x") == nullptr || cloud.find("y") == nullptr || cloud.find("z") == nullptr) {
    return refuse_cloud("a cloud without x, y and z as floating point of 32 bits");
  }
  return cloud;
}

bool is_organised(const Cloud& cloud) {
  return cloud.height > 1 && cloud.width > 1;
}

template <typename T>
T value_of(const Cloud& cloud, const CloudField& field, std::size_t point) {
  ByteReader reader(cloud.data.subspan(point + field.offset, sizeof(T)));
  return (cloud.is_big_endian ? reader.big_endian<T>() : reader.little_endian<T>()).value_or(T{});
}

/// Calls `take(point)` with the offset of each point, row by row.
template <typename Take>
void visit_points(const Cloud& cloud, Take take) {
  for (std::uint32_t v = 0; v < cloud.height; ++v) {
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      take(std::size_t{v} * cloud.row_step + std::size_t{u} * cloud.point_step);
    }
  }
}

/// PCL packs colour as 0x00RRGGBB in four bytes, whether the field is called floating point or not.
ColourImage colours_of_cloud(const Cloud& cloud, const CloudField& field) {
  ColourImage colour(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  auto pixel = colour.pixels().begin();
  visit_points(cloud, [&](std::size_t point) {
    const auto packed = value_of<std::uint32_t>(cloud, field, point);
    *pixel++ = {static_cast<std::uint8_t>(packed >> 16 & 0xFF), static_cast<std::uint8_t>(packed >> 8 & 0xFF),
                static_cast<std::uint8_t>(packed & 0xFF)};
  });
  return colour;
}

Result<void> check_cloud(const Cloud& cloud, const Limits& limits) {
  if (!is_organised(cloud)) {
    return refuse_cloud("the cloud is not organised (height " + std::to_string(cloud.height) +
                        "): a picture of width x height points is needed");
  }
  const auto points = checked_mul<std::uint64_t>(cloud.width, cloud.height);
  if (!points || *points > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return refuse_cloud("a cloud of " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                        " points is not read");
  }
  const bool fits = cloud.row_step >= std::uint64_t{cloud.width} * cloud.point_step &&
                    cloud.data.size() >= std::uint64_t{cloud.row_step} * cloud.height;
  return fits ? Result<void>() : refuse_cloud("the cloud contradicts itself about its size");
}

}  // namespace

Result<Ros2CloudHead> parse_cloud_head(const RosMessage& message) {
  auto cloud = parse_cloud(message);
  if (!cloud) return cloud.error();
  return Ros2CloudHead{std::move(cloud->header), is_organised(*cloud), cloud->find_colour() != nullptr};
}

Result<Ros2CloudFrame> decode_ros2_cloud(const RosMessage& message, const Limits& limits) {
  const auto cloud = parse_cloud(message);
  if (!cloud) return cloud.error();
  if (const auto checked = check_cloud(*cloud, limits); !checked) return checked.error();
  const CloudField &x = *cloud->find("x"), &y = *cloud->find("y"), &z = *cloud->find("z");
  std::vector<Eigen::Vector3f> points_m;
  points_m.reserve(std::size_t{cloud->width} * cloud->height);
  visit_points(*cloud, [&](std::size_t point) {
    points_m.emplace_back(value_of<float>(*cloud, x, point), value_of<float>(*cloud, y, point),
                          value_of<float>(*cloud, z, point));
  });
  auto picture = picture_of_cloud(static_cast<int>(cloud->width), static_cast<int>(cloud->height), points_m);
  if (!picture.camera && picture.has_enough_points) {
    return refuse_cloud(
        "the cloud's points do not lie where the pixels of a camera look (x right, y down, z forward in its frame "
        "'" +
        cloud->header.frame + "'): it is no camera's picture");
  }
  Ros2CloudFrame frame{std::move(picture.depth_m), {}, picture.camera};
  if (const CloudField* rgb = cloud->find_colour()) frame.colour = colours_of_cloud(*cloud, *rgb);
  return frame;
}

}  // namespace scanknit
