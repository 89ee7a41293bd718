// Organised point clouds of PCL, one PCD file a frame.
#include <algorithm>
#include <cmath>
#include <string>

#include "acquire/layouts/pcd_points.h"
#include "acquire/line_sums.h"
#include "acquire/pcl/acquire_pcl.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxPixelResidual = 1.0;  // a cloud whose points miss their pixels by more is no pinhole picture
constexpr std::size_t kFewestPoints = 16;

bool is_pcd(const std::string& name) {
  return fs::path(name).extension() == ".pcd";
}

// {focal, centre} of pixel = focal * slope + centre; nothing when the points do not determine them, or do not follow
// them.
std::optional<std::pair<double, double>> focal_and_centre(const LineSums& pixel_of_slope) {
  if (pixel_of_slope.n < static_cast<double>(kFewestPoints)) return std::nullopt;
  if (!(pixel_of_slope.variance() > 1e-8)) return std::nullopt;  // a view of less than 0.0001 rad
  const double focal = pixel_of_slope.slope();
  const bool is_pinhole = std::isfinite(focal) && focal != 0 && pixel_of_slope.residual() <= kMaxPixelResidual;
  if (!is_pinhole) return std::nullopt;
  return std::pair(focal, (pixel_of_slope.y - focal * pixel_of_slope.x) / pixel_of_slope.n);
}

struct CloudPicture {
  DepthImage depth_m;
  std::optional<CameraIntrinsics> camera;
};

CloudPicture to_depth(const PcdPoints& cloud) {
  CloudPicture picture{DepthImage(cloud.header.width, cloud.header.height), {}};
  LineSums across;
  LineSums down;
  std::size_t i = 0;
  for (int v = 0; v < picture.depth_m.height(); ++v) {
    for (int u = 0; u < picture.depth_m.width(); ++u, ++i) {
      const Eigen::Vector3f& p = cloud.points_m[i];
      if (!p.allFinite() || !(p.z() > 0)) continue;
      picture.depth_m.at(u, v) = p.z();
      across.add(double{p.x()} / p.z(), u);
      down.add(double{p.y()} / p.z(), v);
    }
  }
  const auto horizontal = focal_and_centre(across);
  const auto vertical = focal_and_centre(down);
  if (horizontal && vertical) {
    picture.camera = CameraIntrinsics{picture.depth_m.width(), picture.depth_m.height(), horizontal->first,
                                      vertical->first,         horizontal->second,       vertical->second};
  }
  return picture;
}

OrDrop<DecodedFrame> decode_pcd_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  const auto unreadable = [&](std::string what) {
    return make_drop(DropReason::kUnreadable, std::move(what), entry.depth);
  };
  auto bytes = read_picture(entry.depth, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto cloud = parse_pcd_points(std::get<0>(bytes), settings.limits);
  if (!cloud) return unreadable(cloud.error().message);
  if (cloud->header.height < 2 || cloud->header.width < 2) {
    return unreadable("the cloud is not organised (HEIGHT 1): a picture of width x height points is needed");
  }
  DecodedFrame frame;
  CloudPicture picture = to_depth(*cloud);
  frame.depth_m = std::move(picture.depth_m);
  frame.camera = picture.camera;
  if (!cloud->colours.empty()) {
    frame.colour = ColourImage(cloud->header.width, cloud->header.height);
    std::copy(cloud->colours.begin(), cloud->colours.end(), frame.colour.pixels().begin());
  }
  frame.T_world_camera = viewpoint_pose(cloud->header);
  return frame;
}

}  // namespace

bool fits_pcd(const Folder& folder, const Limits&) {
  return std::any_of(folder.files.begin(), folder.files.end(), is_pcd);
}

Result<Recording> index_pcd(const Folder& folder, const AcquireConfig&) {
  if (const auto pcl = load_acquire_pcl(); !pcl) return pcl.error();  // else every frame would be dropped for it
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
