// Organised point clouds of PCL, one PCD file a frame. PCL parses the body once our own check of the header passed.
#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>

#include "acquire/replay/layouts.h"
#include "acquire/replay/pcd_header.h"
#include "acquire/replay/picture_codec.h"
#include "core/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxPixelResidual = 1.0;  // a cloud whose points miss their pixels by more is no pinhole picture
constexpr std::size_t kFewestPoints = 16;

bool is_pcd(const std::string& name) {
  return fs::path(name).extension() == ".pcd";
}

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

// Least squares of pixel = focal * slope + centre.
class LineFit {
 public:
  void add(double slope, double pixel) {
    n_ += 1;
    s_ += slope;
    p_ += pixel;
    ss_ += slope * slope;
    sp_ += slope * pixel;
    pp_ += pixel * pixel;
  }
  // {focal, centre}; nothing when the points do not settle them, or do not follow them.
  [[nodiscard]] std::optional<std::pair<double, double>> solve() const {
    if (n_ < static_cast<double>(kFewestPoints)) return std::nullopt;
    const double variance = ss_ / n_ - (s_ / n_) * (s_ / n_);
    if (!(variance > 1e-8)) return std::nullopt;  // a view of less than 0.0001 rad
    const double focal = (sp_ / n_ - s_ / n_ * (p_ / n_)) / variance;
    const double pixel_variance = pp_ / n_ - (p_ / n_) * (p_ / n_);
    const double residual = std::sqrt(std::max(0.0, pixel_variance - focal * focal * variance));
    if (!std::isfinite(focal) || focal == 0 || !(residual <= kMaxPixelResidual)) return std::nullopt;
    return std::pair(focal, (p_ - focal * s_) / n_);
  }

 private:
  double n_ = 0, s_ = 0, p_ = 0, ss_ = 0, sp_ = 0, pp_ = 0;
};

struct CloudPicture {
  DepthImage depth_m;
  std::optional<CameraIntrinsics> camera;
};

CloudPicture to_depth(const pcl::PCLPointCloud2& cloud, const PcdField& fx, const PcdField& fy, const PcdField& fz) {
  CloudPicture picture{DepthImage(static_cast<int>(cloud.width), static_cast<int>(cloud.height)), {}};
  LineFit across;
  LineFit down;
  std::size_t i = 0;
  for (int v = 0; v < picture.depth_m.height(); ++v) {
    for (int u = 0; u < picture.depth_m.width(); ++u, ++i) {
      const auto x = value_at<float>(cloud, fx, i);
      const auto y = value_at<float>(cloud, fy, i);
      const auto z = value_at<float>(cloud, fz, i);
      if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z) || !(z > 0)) continue;
      picture.depth_m.at(u, v) = z;
      across.add(double{x} / z, u);
      down.add(double{y} / z, v);
    }
  }
  const auto horizontal = across.solve();
  const auto vertical = down.solve();
  if (horizontal && vertical) {
    picture.camera = CameraIntrinsics{picture.depth_m.width(), picture.depth_m.height(), horizontal->first,
                                      vertical->first,         horizontal->second,       vertical->second};
  }
  return picture;
}

// PCL packs colour as 0x00RRGGBB in four bytes, whether the field is called a float (rgb) or an integer (rgba).
ColourImage to_colour(const pcl::PCLPointCloud2& cloud, const PcdField& field) {
  ColourImage colour(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const auto packed = value_at<std::uint32_t>(cloud, field, i);
    colour.pixels()[i] = {static_cast<std::uint8_t>(packed >> 16 & 0xFF), static_cast<std::uint8_t>(packed >> 8 & 0xFF),
                          static_cast<std::uint8_t>(packed & 0xFF)};
  }
  return colour;
}

Result<Pose> viewpoint_pose(const PcdHeader& header, const fs::path& path) {
  const auto& [tx, ty, tz, qw, qx, qy, qz] = header.viewpoint;
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  if (!(std::abs(q.norm() - 1) <= 0.01)) {
    return Error{ErrorCode::kInput, "VIEWPOINT is not rigid: its quaternion's length is not 1", path.string()};
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  matrix.topRightCorner<3, 1>() << tx, ty, tz;
  return pose_from_matrix(matrix);
}

OrDrop<DecodedFrame> decode_pcd_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  const auto unreadable = [&](std::string what) {
    return make_drop(DropReason::kUnreadable, std::move(what), entry.depth);
  };
  auto bytes = read_picture(entry.depth, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto header = parse_pcd_header(std::get<0>(bytes), settings.limits);
  if (!header) return unreadable(header.error().message);
  if (header->height < 2 || header->width < 2) {
    return unreadable("the cloud is not organised (HEIGHT 1): a picture of width x height points is needed");
  }
  const PcdField* x = find_field(*header, "x", 4);
  const PcdField* y = find_field(*header, "y", 4);
  const PcdField* z = find_field(*header, "z", 4);
  if (x == nullptr || y == nullptr || z == nullptr || x->type != 'F' || y->type != 'F' || z->type != 'F') {
    return unreadable("no x, y, z as 4-byte floats");
  }
  const auto cloud = read_points(std::get<0>(bytes), *header);
  if (!cloud) return unreadable("PCL cannot read the points");

  DecodedFrame frame;
  CloudPicture picture = to_depth(*cloud, *x, *y, *z);
  frame.depth_m = std::move(picture.depth_m);
  frame.camera = picture.camera;
  const PcdField* colour = find_field(*header, "rgb", 4);
  if (colour == nullptr) colour = find_field(*header, "rgba", 4);
  if (colour != nullptr) frame.colour = to_colour(*cloud, *colour);
  frame.T_world_camera = viewpoint_pose(*header, entry.depth);
  return frame;
}

}  // namespace

bool fits_pcd(const Folder& folder, const Limits&) {
  return std::any_of(folder.files.begin(), folder.files.end(), is_pcd);
}

Result<Recording> index_pcd(const Folder& folder, const AcquireConfig&) {
  Recording recording{.format = "pcd", .folder = folder.path};
  recording.frames_bring_camera = true;
  recording.frames_bring_pose = true;
  recording.has_metric_depth = true;
  recording.decode = decode_pcd_frame;
  for (const std::string& name : folder.files) {
    if (is_pcd(name)) recording.entries.push_back({.sequence = recording.entries.size(), .depth = folder.path / name});
  }
  return recording;
}

}  // namespace scanknit
