#include "fusion/loops/key_frames.h"

#include <utility>

#include "fusion/register/motion_vector.h"

namespace scanknit {
namespace {

// A key frame is due when the camera has moved by this share of the depth that it sees, or turned so far.
constexpr double kMoved = 0.12;
constexpr double kTurned_rad = 0.15;

}  // namespace

void KeyFrames::add(const Frame& frame, const Pose& T_world_camera, bool follows_gap) {
  if (follows_gap) ++path_.gaps;
  if (!walk_.empty() && !follows_gap) {
    const Pose step = walk_.back().inverse() * T_world_camera;
    path_.walked_m += step.translation().norm();
    path_.turned_rad += angle_of(step);
  }
  walk_.push_back(T_world_camera);
  if (!kept_.empty() && !follows_gap && !is_new_place(T_world_camera)) return;
  SurfacePyramid seen = pyramid_of(frame, noise_);
  const double depth_m = median_depth_m(seen.levels.back());
  if (!(depth_m > 0)) return;
  std::vector<Feature> features = find_features(seen.levels.front());
  if (!ferns_) ferns_.emplace(depth_m);
  FernCode code = ferns_->encode(seen.levels.back());
  kept_.push_back(
      {walk_.size() - 1, T_world_camera, path_, depth_m, std::move(seen), std::move(features), std::move(code)});
  if (kept_.size() > most_) thin_out();
}

bool KeyFrames::is_new_place(const Pose& T_world_camera) const {
  const KeyFrame& last = kept_.back();
  const Pose moved = last.T_world_camera.inverse() * T_world_camera;
  return moved.translation().norm() > spacing_ * kMoved * last.depth_m || angle_of(moved) > spacing_ * kTurned_rad;
}

void KeyFrames::replace(std::size_t first, const std::vector<Pose>& T_first_frames) {
  if (T_first_frames.empty()) return;
  const Pose T_world_first = walk_[first];
  const std::size_t last = first + T_first_frames.size() - 1;
  const Pose T_new_old = T_world_first * T_first_frames.back() * walk_[last].inverse();
  for (std::size_t i = first; i < walk_.size(); ++i) {
    walk_[i] = i <= last ? Pose(T_world_first * T_first_frames[i - first]) : Pose(T_new_old * walk_[i]);
  }
  for (KeyFrame& key : kept_) key.T_world_camera = walk_[key.frame];
}

/// The first and every other one stay.
void KeyFrames::thin_out() {
  std::vector<KeyFrame> stay;
  for (std::size_t i = 0; i < kept_.size(); i += 2) stay.push_back(std::move(kept_[i]));
  kept_ = std::move(stay);
  spacing_ *= 1.6;
}

}  // namespace scanknit
