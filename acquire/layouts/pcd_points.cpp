#include "acquire/layouts/pcd_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "acquire/pcl/acquire_pcl.h"

namespace scanknit {
namespace {

const PcdField* find_field(const PcdHeader& header, std::string_view name, std::size_t size) {
  const auto match = std::find_if(header.fields.begin(), header.fields.end(), [&](const PcdField& field) {
    return field.name == name && field.size == size && field.count == 1;
  });
  return match == header.fields.end() ? nullptr : &*match;
}

// All points' bytes, and how they lie.
struct PcdBody {
  const PcdHeader& header;
  std::vector<std::uint8_t> bytes;
  [[nodiscard]] std::size_t points() const { return bytes.size() / header.point_bytes; }
};

// The value of `field` of point i.
template <typename T>
T value_at(const PcdBody& body, const PcdField& field, std::size_t i) {
  T value;
  std::memcpy(&value, body.bytes.data() + i * body.header.point_bytes + field.offset, sizeof(T));
  return value;
}

bool is_float(const PcdField* field) {
  return field != nullptr && field->type == 'F';
}

/// The values of three fields, point by point.
std::vector<Eigen::Vector3f> triples(const PcdBody& body, const PcdField& x, const PcdField& y, const PcdField& z) {
  std::vector<Eigen::Vector3f> values(body.points());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = {value_at<float>(body, x, i), value_at<float>(body, y, i), value_at<float>(body, z, i)};
  }
  return values;
}

// PCL packs colour as 0x00RRGGBB in four bytes, whether the field is called a float (rgb) or an integer (rgba).
std::vector<Rgb8> colours_of(const PcdBody& body, const PcdField& field) {
  std::vector<Rgb8> colours(body.points());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const auto packed = value_at<std::uint32_t>(body, field, i);
    colours[i] = {static_cast<std::uint8_t>(packed >> 16 & 0xFF), static_cast<std::uint8_t>(packed >> 8 & 0xFF),
                  static_cast<std::uint8_t>(packed & 0xFF)};
  }
  return colours;
}

}  // namespace

Result<PcdPoints> parse_pcd_points(std::span<const std::byte> bytes, const Limits& limits) {
  const auto header = parse_pcd_header(bytes, limits);
  if (!header) return header.error();
  const auto field = [&](std::string_view name) { return find_field(*header, name, 4); };
  const PcdField* x = field("x");
  const PcdField* y = field("y");
  const PcdField* z = field("z");
  if (!is_float(x) || !is_float(y) || !is_float(z)) {
    return Error{ErrorCode::kInput, "no x, y, z as 4-byte floats"};
  }
  const auto pcl = load_acquire_pcl();
  if (!pcl) return pcl.error();
  auto read = (*pcl)->read_pcd_points(bytes, *header);
  if (!read) return Error{ErrorCode::kInput, "PCL cannot read the points"};

  const PcdBody body{*header, *std::move(read)};
  PcdPoints points{*header, triples(body, *x, *y, *z), {}, {}};
  const PcdField* nx = field("normal_x");
  const PcdField* ny = field("normal_y");
  const PcdField* nz = field("normal_z");
  if (is_float(nx) && is_float(ny) && is_float(nz)) points.normals = triples(body, *nx, *ny, *nz);
  const PcdField* colour = field("rgb");
  if (colour == nullptr) colour = field("rgba");
  if (colour != nullptr) points.colours = colours_of(body, *colour);
  return points;
}

Result<Pose> viewpoint_pose(const PcdHeader& header) {
  const auto& [tx, ty, tz, qw, qx, qy, qz] = header.viewpoint;
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  if (!(std::abs(q.norm() - 1) <= 0.01)) {
    return Error{ErrorCode::kInput, "VIEWPOINT is not rigid: its quaternion's length is not 1"};
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  matrix.topRightCorner<3, 1>() << tx, ty, tz;
  return pose_from_matrix(matrix);
}

}  // namespace scanknit
