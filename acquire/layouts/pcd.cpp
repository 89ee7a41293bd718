// Organised point clouds of PCL, one PCD file a frame.
#include <algorithm>
#include <string>

#include "acquire/layouts/pcd_points.h"
#include "acquire/pcl/acquire_pcl.h"
#include "acquire/pcl/cloud_picture.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

bool is_pcd(const std::string& name) {
  return fs::path(name).extension() == ".pcd";
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
  CloudPicture picture = picture_of_cloud(cloud->header.width, cloud->header.height, cloud->points_m);
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
