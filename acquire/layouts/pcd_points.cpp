#include "acquire/layouts/pcd_points.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>

namespace scanknit {
namespace {

const PcdField* find_field(const PcdHeader& header, std::string_view name, std::size_t size) {
  const auto match = std::find_if(header.fields.begin(), header.fields.end(), [&](const PcdField& field) {
    return field.name == name && field.size == size && field.count == 1;
  });
  return match == header.fields.end() ? nullptr : &*match;
}

// The points through PCL, or nothing when it refuses them.
std::optional<pcl::PCLPointCloud2> read_points(std::span<const std::byte> bytes, const PcdHeader& expected) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // a library never prints on input
  try {
    pcl::PCDReader reader;
    pcl::PCLPointCloud2 cloud;
    std::string text(bytes.size(), '\0');
    std::memcpy(text.data(), bytes.data(), bytes.size());
    std::istringstream stream(text);
    Eigen::Vector4f origin;
    Eigen::Quaternionf orientation;
    int version = 0;
    int encoding = 0;
    unsigned int body = 0;
    if (reader.readHeader(stream, cloud, origin, orientation, version, encoding, body) != 0) return std::nullopt;
    // PCL's reading of the header must be ours, since ours is the one that was checked.
    const bool agrees = cloud.width == static_cast<std::uint32_t>(expected.width) &&
                        cloud.height == static_cast<std::uint32_t>(expected.height) &&
                        cloud.point_step == expected.point_bytes && body == expected.header_bytes &&
                        encoding == static_cast<int>(expected.encoding);
    if (!agrees) return std::nullopt;
    cloud.data.resize(std::size_t{cloud.width} * cloud.height * cloud.point_step);
    int status = 0;
    if (expected.encoding == PcdEncoding::kAscii) {
      stream.clear();
      stream.seekg(body);
      status = reader.readBodyASCII(stream, cloud, version);
    } else {
      std::vector<unsigned char> raw(bytes.size());
      std::memcpy(raw.data(), bytes.data(), bytes.size());
      const bool is_compressed = expected.encoding == PcdEncoding::kBinaryCompressed;
      status = reader.readBodyBinary(raw.data(), cloud, version, is_compressed, body);
    }
    if (status != 0) return std::nullopt;
    return cloud;
  } catch (const std::exception&) {  // pcl::IOException, std::bad_alloc, boost's casts
    return std::nullopt;
  }
}

// Values of `field` of point i, from PCL's bytes.
template <typename T>
T value_at(const pcl::PCLPointCloud2& cloud, const PcdField& field, std::size_t i) {
  T value;
  std::memcpy(&value, cloud.data.data() + i * cloud.point_step + field.offset, sizeof(T));
  return value;
}

bool is_float(const PcdField* field) {
  return field != nullptr && field->type == 'F';
}

/// The values of three fields, point by point.
std::vector<Eigen::Vector3f> triples(const pcl::PCLPointCloud2& cloud, const PcdField& x, const PcdField& y,
                                     const PcdField& z) {
  std::vector<Eigen::Vector3f> values(std::size_t{cloud.width} * cloud.height);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = {value_at<float>(cloud, x, i), value_at<float>(cloud, y, i), value_at<float>(cloud, z, i)};
  }
  return values;
}

// PCL packs colour as 0x00RRGGBB in four bytes, whether the field is called a float (rgb) or an integer (rgba).
std::vector<Rgb8> colours_of(const pcl::PCLPointCloud2& cloud, const PcdField& field) {
  std::vector<Rgb8> colours(std::size_t{cloud.width} * cloud.height);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const auto packed = value_at<std::uint32_t>(cloud, field, i);
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
  const auto cloud = read_points(bytes, *header);
  if (!cloud) return Error{ErrorCode::kInput, "PCL cannot read the points"};

  PcdPoints points{*header, triples(*cloud, *x, *y, *z), {}, {}};
  const PcdField* nx = field("normal_x");
  const PcdField* ny = field("normal_y");
  const PcdField* nz = field("normal_z");
  if (is_float(nx) && is_float(ny) && is_float(nz)) points.normals = triples(*cloud, *nx, *ny, *nz);
  const PcdField* colour = field("rgb");
  if (colour == nullptr) colour = field("rgba");
  if (colour != nullptr) points.colours = colours_of(*cloud, *colour);
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
