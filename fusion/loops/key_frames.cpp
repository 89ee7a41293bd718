#include "fusion/loops/key_frames.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "core/check.h"
#include "fusion/register/motion_vector.h"

namespace scanknit {
namespace {

// A key frame is due when the camera has moved by this share of the depth that it sees, or turned so far.
constexpr double kMoved = 0.12;
constexpr double kTurned_rad = 0.15;

}  // namespace

void KeyFrames::add(const Frame& frame, const Pose& T_world_camera, bool follows_gap) {
  walk_.push_back(T_world_camera);
  follows_gap_.push_back(follows_gap);
  walk_on_to(walk_.size() - 1);
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

/// path_ up to this frame, from that up to the frame before it.
void KeyFrames::walk_on_to(std::size_t frame) {
  if (follows_gap_[frame]) {
    ++path_.gaps;
  } else if (frame > 0) {
    const Pose step = walk_[frame - 1].inverse() * walk_[frame];
    path_.walked_m += step.translation().norm();
    path_.turned_rad += angle_of(step);
  }
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

KeyFrames KeyFrames::without_frames() const {
  KeyFrames empty(noise_, most_);
  empty.spacing_ = spacing_;
  empty.ferns_ = ferns_;
  return empty;
}

void KeyFrames::reverse() {
  std::reverse(walk_.begin(), walk_.end());
  std::reverse(kept_.begin(), kept_.end());
  for (KeyFrame& key : kept_) key.frame = walk_.size() - 1 - key.frame;
}

void KeyFrames::insert(std::size_t at, KeyFrames found, const std::vector<Pose>& T_world_frames, const Gaps& gaps) {
  const std::size_t count = T_world_frames.size();
  if (count == 0) return;
  SCANKNIT_CHECK(count == found.walk_.size() && at <= walk_.size());
  const auto offset = static_cast<std::ptrdiff_t>(at);
  walk_.insert(walk_.begin() + offset, T_world_frames.begin(), T_world_frames.end());
  if (!ferns_) ferns_ = std::move(found.ferns_);
  if (at < follows_gap_.size()) follows_gap_[at] = gaps.after;
  follows_gap_.insert(follows_gap_.begin() + offset, count, false);
  follows_gap_[at] = gaps.before;
  const auto is_before = [&](const KeyFrame& key) { return key.frame < at; };
  const auto next = std::partition_point(kept_.begin(), kept_.end(), is_before);
  for (auto key = next; key != kept_.end(); ++key) key->frame += count;
  for (KeyFrame& key : found.kept_) key.frame += at;
  kept_.insert(next, std::make_move_iterator(found.kept_.begin()), std::make_move_iterator(found.kept_.end()));
  path_ = {};
  auto key = kept_.begin();
  for (std::size_t frame = 0; frame < walk_.size(); ++frame) {
    walk_on_to(frame);
    if (key == kept_.end() || key->frame != frame) continue;
    key->T_world_camera = walk_[frame];
    (key++)->path = path_;
  }
  while (kept_.size() > most_) thin_out();
}

/// The first and every other one stay.
void KeyFrames::thin_out() {
  std::vector<KeyFrame> stay;
  for (std::size_t i = 0; i < kept_.size(); i += 2) stay.push_back(std::move(kept_[i]));
  kept_ = std::move(stay);
  spacing_ *= 1.6;
}

}  // namespace scanknit
