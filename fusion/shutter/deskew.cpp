#include "fusion/shutter/deskew.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/pixels/typical_depth.h"

namespace scanknit {
namespace {

constexpr double kLeastPixels = 0.5;  // of displacement

/// A pixel as whole numbers; outside of the picture: x < 0.
struct Place {
  int x, y;
};

/// Finds where the pixels of the middle row's time were seen. To first order, a point moves through the picture in
/// proportion to the time before or after the middle row (Longuet-Higgins & Prazdny 1980, "The interpretation of a
/// moving retinal image"), and the row that it reaches is the time: one linear equation.
class RowFinder {
 public:
  RowFinder(const CameraIntrinsics& camera, const SteadyMotion& rows)
      : width_(camera.width),
        height_(static_cast<float>(camera.height)),
        fx_(static_cast<float>(camera.fx)),
        fy_(static_cast<float>(camera.fy)),
        cx_(static_cast<float>(camera.cx)),
        cy_(static_cast<float>(camera.cy)),
        per_fx_(1 / fx_),
        per_fy_(1 / fy_),
        turn_(rows.turn_rad.cast<float>()),
        shift_(rows.shift_m.cast<float>()) {}

  [[nodiscard]] Eigen::Vector3f ray(int x, int y) const {
    return {(static_cast<float>(x) - cx_) * per_fx_, (static_cast<float>(y) - cy_) * per_fy_, 1.0f};
  }

  /// Where the surface that pixel (x, y) shows, at depth 1 / per_z, was seen.
  [[nodiscard]] Place find(int x, int y, float per_z) const {
    const Eigen::Vector3f r = ray(x, y);
    const float nearing = turn_.x() * r.y() - turn_.y() * r.x() + shift_.z() * per_z;
    const float flow_u = fx_ * (turn_.z() * r.y() - turn_.y() - shift_.x() * per_z + r.x() * nearing);
    const float flow_v = fy_ * (turn_.x() - turn_.z() * r.x() - shift_.y() * per_z + r.y() * nearing);
    const float per_height = 1 / height_;
    const float v = (static_cast<float>(y) + flow_v * (0.5f * per_height - 0.5f)) / (1 - flow_v * per_height) + 0.5f;
    const float u = static_cast<float>(x) + flow_u * (v * per_height - 0.5f) + 0.5f;
    const bool is_inside = u >= 0 && v >= 0 && u < static_cast<float>(width_) && v < height_;
    return is_inside ? Place{static_cast<int>(u), static_cast<int>(v)} : Place{-1, -1};
  }

 private:
  int width_;
  float height_;
  float fx_, fy_, cx_, cy_, per_fx_, per_fy_;
  Eigen::Vector3f turn_, shift_;
};

/// The depth of pixel (x, y) on the plane through p; that of p where the plane is seen too obliquely to tell.
float depth_on_plane(const Eigen::Vector3f& ray, const Eigen::Vector3f& p, const Eigen::Vector3f& normal, float fx) {
  constexpr float kMostPixels = 4;  // of a plane that is seen at 45 degrees
  const float z_m = normal.dot(p) / normal.dot(ray);
  return std::abs(z_m - p.z()) < kMostPixels * p.z() / std::abs(fx) ? z_m : p.z();
}

struct FloatPose {
  Eigen::Matrix3f R;
  Eigen::Vector3f t;

  explicit FloatPose(const Pose& pose) : R(pose.linear().cast<float>()), t(pose.translation().cast<float>()) {}
  [[nodiscard]] Eigen::Vector3f operator*(const Eigen::Vector3f& p) const { return R * p + t; }
};

void deskew_surface(const SteadyMotion& rows, float typical_m, Frame& frame) {
  const RowFinder finder(frame.intrinsics, rows);
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  std::vector<FloatPose> T_middle_row;
  for (int y = 0; y < height; ++y) T_middle_row.emplace_back(pose_of_row(rows, y, height));
  const DepthImage seen_m = std::exchange(frame.depth_m, DepthImage(width, height));
  const bool has_normals = !frame.normals.empty();
  auto seen_normals = std::move(frame.normals);
  if (has_normals) frame.normals = Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  const auto per_depth_at = [&](int x, int y) {
    const float z_m = seen_m.at(x, y);
    return 1 / (z_m > 0 ? z_m : typical_m);
  };
  const auto fx = static_cast<float>(frame.intrinsics.fx);
  // Of 1 / z: moves a place by half a pixel.
  const float least_step = 0.5f / std::max(1e-6f, std::abs(fx) * static_cast<float>(rows.shift_m.norm()));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float per_z = per_depth_at(x, y);
      Place seen = finder.find(x, y, per_z);
      if (seen.x < 0) continue;
      const float per_z_there = per_depth_at(seen.x, seen.y);  // another surface, beside an edge
      if (std::abs(per_z_there - per_z) > least_step) seen = finder.find(x, y, per_z_there);
      if (seen.x < 0 || !(seen_m.at(seen.x, seen.y) > 0)) continue;
      const FloatPose& T_middle_this = T_middle_row[static_cast<std::size_t>(seen.y)];
      const Eigen::Vector3f p = T_middle_this * (finder.ray(seen.x, seen.y) * seen_m.at(seen.x, seen.y));
      if (!(p.z() > 0)) continue;
      float z_m = p.z();
      if (has_normals) {
        const Eigen::Vector3f normal = T_middle_this.R * seen_normals.at(seen.x, seen.y);
        frame.normals.at(x, y) = normal;
        z_m = depth_on_plane(finder.ray(x, y), p, normal, fx);
      }
      frame.depth_m.at(x, y) = z_m;
    }
  });
}

/// `rows` in the axes of the depth camera.
void deskew_colour(const SteadyMotion& rows, float typical_m, ColourFrame& colour) {
  const Eigen::Matrix3d R = colour.T_colour_depth.linear();
  const RowFinder finder(colour.intrinsics, {R * rows.turn_rad, R * rows.shift_m});
  const auto seen_image = colour.image;
  colour.encoded = nullptr;
  tbb::parallel_for(0, colour.image.height(), [&](int y) {
    for (int x = 0; x < colour.image.width(); ++x) {
      const Place seen = finder.find(x, y, 1 / typical_m);
      if (seen.x >= 0) colour.image.at(x, y) = seen_image.at(seen.x, seen.y);
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
