#include "fusion/shutter/deskew.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/pixels/pixel_rows.h"
#include "core/pixels/typical_depth.h"
#include "fusion/shutter/deskew_rows.h"

namespace scanknit {
namespace {

constexpr double kLeastPixels = 0.5;  // of displacement

RowPose row_pose(const Pose& pose) {
  RowPose row;
  row << pose.linear().cast<float>(), pose.translation().cast<float>();
  return row;
}

std::size_t padded(int width) {
  return static_cast<std::size_t>((width + kPixelGroup - 1) / kPixelGroup * kPixelGroup);
}

void deskew_surface(const SteadyMotion& rows, float typical_m, Frame& frame) {
  const RowFlow flow(frame.intrinsics, rows);
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  std::vector<RowPose> T_middle_row;
  for (int y = 0; y < height; ++y) T_middle_row.push_back(row_pose(pose_of_row(rows, y, height)));
  const auto seen_m = std::exchange(frame.depth_m, DepthImage::uninitialised(width, height));
  const bool has_normals = !frame.normals.empty();
  const auto seen_normals = std::exchange(frame.normals, {});
  if (has_normals) frame.normals = Image<Eigen::Vector3f>::uninitialised(width, height);
  // Of 1 / z: moves a place by half a pixel.
  const float least_step = 0.5f / std::max(1e-6f, std::abs(flow.fx) * static_cast<float>(rows.shift_m.norm()));
  const SeenSurface seen{seen_m.pixels().data(), has_normals ? seen_normals.pixels().data() : nullptr,
                         T_middle_row.data(), typical_m, least_step};
  tbb::parallel_for(tbb::blocked_range(0, height), [&](const auto& range) {
    std::vector<float> z_m(padded(width));
    std::vector<Eigen::Vector3f> normals(has_normals ? padded(width) : 0);
    for (int y = range.begin(); y < range.end(); ++y) {
      deskew_row(flow, seen, y, z_m.data(), has_normals ? normals.data() : nullptr);
      std::copy_n(z_m.begin(), width, frame.depth_m.row(y).begin());
      if (has_normals) std::copy_n(normals.begin(), width, frame.normals.row(y).begin());
    }
  });
}

/// `rows` in the axes of the depth camera.
void deskew_colour(const SteadyMotion& rows, float typical_m, ColourFrame& colour) {
  const Eigen::Matrix3d R = colour.T_colour_depth.linear();
  const RowFlow flow(colour.intrinsics, {R * rows.turn_rad, R * rows.shift_m});
  const auto seen_image = colour.image;
  colour.encoded = nullptr;
  tbb::parallel_for(tbb::blocked_range(0, colour.image.height()), [&](const auto& range) {
    std::vector<std::int32_t> places(padded(flow.width));
    for (int y = range.begin(); y < range.end(); ++y) {
      find_places(flow, 1 / typical_m, y, places.data());
      const auto row = colour.image.row(y);
      for (std::size_t x = 0; x < row.size(); ++x) {
        if (places[x] >= 0) row[x] = seen_image.pixels()[static_cast<std::size_t>(places[x])];
      }
    }
  });
}

}  // namespace

void deskew(const FrameMotion& motion, Frame& frame) {
  if (motion.is_still()) return;
  const float seen_m = typical_depth_m(frame.depth_m);
  const float typical_m = seen_m > 0 ? seen_m : 1;
  const auto is_seen = [&](const SteadyMotion& part) {
    return part.pixels(frame.intrinsics, static_cast<double>(typical_m)) > kLeastPixels;
  };
  if (is_seen(motion.rows * 0.5)) {
    deskew_surface(motion.rows, typical_m, frame);
    if (frame.colour) deskew_colour(motion.rows, typical_m, *frame.colour);
  }
  if (frame.colour && is_seen(motion.to_colour)) {
    frame.colour->T_colour_depth = frame.colour->T_colour_depth * motion.to_colour.after(1).inverse();
  }
}

}  // namespace scanknit
