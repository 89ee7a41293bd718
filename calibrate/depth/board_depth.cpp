#include "calibrate/depth/board_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <variant>

#include "acquire/frame_source.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/lens/first_guess.h"

namespace scanknit {
namespace {

/// The board's pose in a colour picture and how well it is known.
struct ColourPose {
  Pose T_colour_board;
  PoseMatrix information;
};

ColourPose colour_pose(const BoardView& view, const std::vector<Eigen::Vector2d>& corners_m, const LensVector& lens,
                       double corner_noise_px) {
  constexpr double kFarCorner_px = 1;
  BundleView seen = bundle_view(view, corners_m);
  seen.T_camera_board = guess_pose(lens, seen);
  Bundle bundle{lens, {seen}};
  optimise(bundle, FreeLens::kNone, kFarCorner_px);
  return {bundle.views.front().T_camera_board,
          pose_information(lens, bundle.views.front()) / (corner_noise_px * corner_noise_px)};
}

/// The same in the depth camera's frame.
ColourPose in_depth_camera(const ColourPose& colour, const Pose& T_colour_depth) {
  const PoseMatrix by_step = step_seen_from(T_colour_depth);
  return {T_colour_depth.inverse() * colour.T_colour_board, by_step.transpose() * colour.information * by_step};
}

/// Whether the plate shows at a pixel: its black part, from which nothing hangs over.
bool is_on_board(const Eigen::Vector2d& pixel, const Pose& T_board_depth, const CameraIntrinsics& camera,
                 const Eigen::Vector2d& extent) {
  const Eigen::Vector3d eye = T_board_depth.translation();
  const Eigen::Vector3d ray = T_board_depth.linear() * camera.unproject(pixel.x(), pixel.y(), 1);
  const double t = -eye.z() / ray.z();
  const Eigen::Vector3d at = eye + t * ray;
  return t > 0 && at.x() > 0 && at.y() > 0 && at.x() < extent.x() && at.y() < extent.y();
}

/// The means over square cells that lie on the board and of which most pixels have depth.
std::vector<DepthSample> samples_of(const DepthImage& depth_m, const CameraIntrinsics& camera,
                                    const Pose& T_depth_board, const Eigen::Vector2d& extent) {
  constexpr int kCellsAcross = 80;
  const int cell = std::max(2, depth_m.width() / kCellsAcross);
  const Pose T_board_depth = T_depth_board.inverse();
  std::vector<DepthSample> samples;
  for (int top = 0; top + cell <= depth_m.height(); top += cell) {
    for (int left = 0; left + cell <= depth_m.width(); left += cell) {
      const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(left, top), Eigen::Vector2d(left + cell, top),
                                                      Eigen::Vector2d(left, top + cell),
                                                      Eigen::Vector2d(left + cell, top + cell)};
      if (!std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector2d& corner) {
            return is_on_board(corner, T_board_depth, camera, extent);
          })) {
        continue;
      }
      DepthSample sum;
      int count = 0;
      for (int y = top; y < top + cell; ++y) {
        for (int x = left; x < left + cell; ++x) {
          const auto z = static_cast<double>(depth_m.at(x, y));
          if (!(z > 0)) continue;
          ++count;
          sum.pixel += Eigen::Vector2d(x, y);
          sum.per_m += 1 / z;
        }
      }
      if (2 * count > cell * cell) samples.push_back({sum.pixel / count, sum.per_m / count});
    }
  }
  return samples;
}

/// The motion at each view from the views before and after it, where these are near in time. Views without it go if
/// enough have it: where the board was when depth was taken, they do not tell.
void add_motion(const std::vector<std::int64_t>& times_ns, std::vector<DepthView>& views) {
  constexpr double kMostGap_s = 0.25;
  for (std::size_t i = 1; i + 1 < views.size(); ++i) {
    const double before_s = 1e-9 * static_cast<double>(times_ns[i] - times_ns[i - 1]);
    const double after_s = 1e-9 * static_cast<double>(times_ns[i + 1] - times_ns[i]);
    if (!(before_s > 0) || !(after_s > 0) || before_s > kMostGap_s || after_s > kMostGap_s) continue;
    views[i].motion = motion_through(views[i - 1].T_depth_board, views[i].T_depth_board, views[i + 1].T_depth_board,
                                     before_s, after_s);
  }
  const auto is_known = [](const DepthView& view) { return view.motion.has_value(); };
  if (std::count_if(views.begin(), views.end(), is_known) >= static_cast<std::ptrdiff_t>(kFewestDepthViews)) {
    std::erase_if(views, [&](const DepthView& view) { return !is_known(view); });
  }
}

}  // namespace

Result<BoardDepths> read_board_depths(const std::filesystem::path& path, const AcquireConfig& acquire,
                                      const std::vector<BoardView>& views, const CameraModel& lens,
                                      double corner_noise_px, const CalibrationTarget& target,
                                      const std::stop_token& stop) {
  std::map<std::string, const BoardView*> by_name;
  for (const BoardView& view : views) by_name.emplace(view.picture, &view);
  auto source = open_recording(path, acquire);
  if (!source) return source.error();
  const auto corners_m = target_corners(target);
  BoardDepths result;
  std::vector<std::int64_t> times_ns;
  for (;;) {
    const FrameEvent event = (*source)->next(stop);
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    const auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr || !frame->colour) continue;
    const auto view = by_name.find(board_frame_name(*frame));
    if (view == by_name.end()) continue;
    result.camera = frame->intrinsics;
    result.T_colour_depth = frame->colour->T_colour_depth;
    result.has_clock = frame->has_clock;
    const ColourPose pose = in_depth_camera(colour_pose(*view->second, corners_m, lens_of(lens), corner_noise_px),
                                            frame->colour->T_colour_depth);
    DepthView seen{.samples = samples_of(frame->depth_m, frame->intrinsics, pose.T_colour_board, extent_m(target)),
                   .T_depth_board = pose.T_colour_board,
                   .information = pose.information,
                   .motion = {}};
    result.views.push_back(std::move(seen));
    times_ns.push_back(frame->timestamp_ns);
  }
  if (result.has_clock) add_motion(times_ns, result.views);
  return result;
}

}  // namespace scanknit
