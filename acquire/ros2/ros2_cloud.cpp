#include "acquire/ros2/ros2_cloud.h"

#include <Eigen/Core>
#include <initializer_list>
#include <utility>
#include <vector>

#include "acquire/pcl/cloud_picture.h"
#include "core/checked_math.h"

namespace scanknit {
namespace {

constexpr const char* kNoPoints = "a cloud without x, y and z as floating point of 32 bits";

Error refuse_cloud(const std::string& what) {
  return {ErrorCode::kInput, what};
}

struct PointPlace {
  const CloudField *x = nullptr, *y = nullptr, *z = nullptr;

  [[nodiscard]] bool is_whole() const { return x != nullptr && y != nullptr && z != nullptr; }
};

PointPlace find_place(const CloudMessage& cloud, std::initializer_list<CloudType> types) {
  return {cloud.find("x", types), cloud.find("y", types), cloud.find("z", types)};
}

const CloudField* find_colour(const CloudMessage& cloud) {
  const auto types = {CloudType::kUint32, CloudType::kFloat32};
  const CloudField* rgb = cloud.find("rgb", types);
  return rgb != nullptr ? rgb : cloud.find("rgba", types);
}

/// Rows of one laser each are those of a LiDAR, not of a picture.
bool is_picture(const CloudMessage& cloud) {
  return cloud.has_rows() && find_ring(cloud) == nullptr;
}

/// PCL packs colour as 0x00RRGGBB in four bytes, whether the field is called floating point or not.
ColourImage colours_of_cloud(const CloudMessage& cloud, const CloudField& field) {
  ColourImage colour(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  auto pixel = colour.pixels().begin();
  cloud.visit_points([&](std::size_t point) {
    const auto packed = cloud.value<std::uint32_t>(field, point);
    *pixel++ = {static_cast<std::uint8_t>(packed >> 16 & 0xFF), static_cast<std::uint8_t>(packed >> 8 & 0xFF),
                static_cast<std::uint8_t>(packed & 0xFF)};
  });
  return colour;
}

Result<void> check_cloud(const CloudMessage& cloud, const Limits& limits) {
  if (!cloud.has_rows()) {
    return refuse_cloud("the cloud is not organised (height " + std::to_string(cloud.height) +
                        "): a picture of width x height points is needed");
  }
  const auto points = checked_mul<std::uint64_t>(cloud.width, cloud.height);
  if (!points || *points > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return refuse_cloud("a cloud of " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                        " points is not read");
  }
  return cloud.has_all_points() ? Result<void>() : refuse_cloud("the cloud contradicts itself about its size");
}

}  // namespace

const CloudField* find_ring(const CloudMessage& cloud) {
  const auto types = {CloudType::kUint8, CloudType::kUint16, CloudType::kUint32};
  const CloudField* ring = cloud.find("ring", types);
  return ring != nullptr ? ring : cloud.find("channel", types);
}

Result<Ros2CloudHead> parse_cloud_head(const RosMessage& message) {
  const auto cloud = parse_cloud_message(message);
  if (!cloud) return cloud.error();
  const bool has_single = find_place(*cloud, {CloudType::kFloat32}).is_whole();
  const bool has_double = find_place(*cloud, {CloudType::kFloat64}).is_whole();
  if (!has_single && !has_double) return refuse_cloud("a cloud without x, y and z as floating point");
  if (is_picture(*cloud) && !has_single) return refuse_cloud(kNoPoints);
  const bool has_colour = find_colour(*cloud) != nullptr;
  return Ros2CloudHead{cloud->header, is_picture(*cloud), has_colour};
}

Result<Ros2CloudFrame> decode_ros2_cloud(const RosMessage& message, const Limits& limits) {
  const auto cloud = parse_cloud_message(message);
  if (!cloud) return cloud.error();
  const PointPlace place = find_place(*cloud, {CloudType::kFloat32});
  if (!place.is_whole()) return refuse_cloud(kNoPoints);
  if (const auto checked = check_cloud(*cloud, limits); !checked) return checked.error();
  std::vector<Eigen::Vector3f> points_m;
  points_m.reserve(std::size_t{cloud->width} * cloud->height);
  cloud->visit_points([&](std::size_t point) {
    points_m.emplace_back(cloud->value<float>(*place.x, point), cloud->value<float>(*place.y, point),
                          cloud->value<float>(*place.z, point));
  });
  auto picture = picture_of_cloud(static_cast<int>(cloud->width), static_cast<int>(cloud->height), points_m);
  if (!picture.camera && picture.has_enough_points) {
    return refuse_cloud(
        "the cloud's points do not lie where the pixels of a camera look (x right, y down, z forward in its frame "
        "'" +
        cloud->header.frame + "'): it is no camera's picture");
  }
  Ros2CloudFrame frame{std::move(picture.depth_m), {}, picture.camera};
  if (const CloudField* rgb = find_colour(*cloud)) frame.colour = colours_of_cloud(*cloud, *rgb);
  return frame;
}

}  // namespace scanknit
