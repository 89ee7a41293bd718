#include "fusion/track/relocaliser.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "fusion/register/motion_vector.h"

namespace scanknit {
namespace {

constexpr double kNewPlace = 0.15;       // a frame that differs by more from all key frames becomes one
constexpr std::size_t kMostKeys = 2000;  // some 50 MB of features
constexpr std::size_t kSimilar = 4;      // candidates: each costs a raycast
constexpr std::size_t kMatched = 12;     // key frames whose features are compared
constexpr std::size_t kMostMatches = 3;

// Finding features takes longer than registering a frame, and those of a view from near would say the same: one whose
// camera is no farther than this share of the depth that it sees, nor turned by more than this.
constexpr double kNear = 0.12;
constexpr double kNear_rad = 0.15;

}  // namespace

void Relocaliser::learn(const SurfacePyramid& frame, const Pose& T_world_camera) {
  if (keys_.size() == kMostKeys) return;
  if (points_of(frame.levels.back()) == 0) return;
  if (!ferns_) ferns_.emplace(median_depth_m(frame.levels.back()));
  FernCode code = ferns_->encode(frame.levels.back());
  const bool is_known = std::any_of(keys_.begin(), keys_.end(),
                                    [&](const KeyFrame& key) { return dissimilarity(key.code, code) < kNewPlace; });
  if (is_known) return;
  KeyFrame key{std::move(code), T_world_camera, {}};
  if (!has_features_near(T_world_camera, median_depth_m(frame.levels.back()))) {
    key.features = find_features(frame.levels.front());
  }
  keys_.push_back(std::move(key));
}

std::size_t Relocaliser::key_frames_with_features() const {
  return static_cast<std::size_t>(
      std::count_if(keys_.begin(), keys_.end(), [](const KeyFrame& key) { return !key.features.empty(); }));
}

bool Relocaliser::has_features_near(const Pose& T_world_camera, double depth_m) const {
  return std::any_of(keys_.begin(), keys_.end(), [&](const KeyFrame& key) {
    if (key.features.empty()) return false;
    const Pose apart = key.T_world_camera.inverse() * T_world_camera;
    return apart.translation().norm() < kNear * depth_m && angle_of(apart) < kNear_rad;
  });
}

std::vector<const Relocaliser::KeyFrame*> Relocaliser::most_alike(const SurfacePyramid& frame, std::size_t count,
                                                                  bool with_features) const {
  if (!ferns_) return {};
  const FernCode code = ferns_->encode(frame.levels.back());
  std::vector<std::pair<double, std::size_t>> order;  // ties go to the older key frame
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (with_features && keys_[i].features.empty()) continue;
    order.emplace_back(dissimilarity(keys_[i].code, code), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<const KeyFrame*> alike;
  for (const auto& [difference, i] : order) {
    if (alike.size() < count && difference < 1) alike.push_back(&keys_[i]);
  }
  return alike;
}

std::vector<Pose> Relocaliser::similar_poses(const SurfacePyramid& frame) const {
  std::vector<Pose> poses;
  for (const KeyFrame* key : most_alike(frame, kSimilar, /*with_features=*/false)) poses.push_back(key->T_world_camera);
  return poses;
}

std::vector<Pose> Relocaliser::matched_poses(const SurfacePyramid& frame) const {
  std::vector<Pose> poses;
  const std::vector<Feature> features = find_features(frame.levels.front());
  const std::vector<const KeyFrame*> keys = most_alike(frame, kMatched, /*with_features=*/true);
  std::vector<std::optional<Pose>> T_key_frames(keys.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) {
    T_key_frames[i] = match_features(keys[i]->features, features, frame.levels.front().intrinsics);
  });
  for (std::size_t i = 0; i < keys.size() && poses.size() < kMostMatches; ++i) {
    if (T_key_frames[i]) poses.push_back(keys[i]->T_world_camera * *T_key_frames[i]);
  }
  return poses;
}

}  // namespace scanknit
