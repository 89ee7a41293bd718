#include "fusion/track/model_tracker.h"

#include <algorithm>
#include <cmath>

#include "fusion/register/motion_vector.h"
#include "fusion/register/picture_shift.h"
#include "fusion/track/raycast.h"
#include "fusion/track/still_camera.h"

namespace scanknit {
namespace {

// A frame with a surface at fewer of its pixels says too little.
constexpr double kFewestPoints = 0.03;

// Nearer than this most depth cameras see nothing.
constexpr double kTooClose_m = 0.7;

// Of the points, the share that must lie before something known; of those, the share that must agree with it.
constexpr double kLeastOverlap = 0.15;
constexpr double kLeastInliers = 0.5;
constexpr double kGoodInliers = 0.65;

// Colours of the right place agree to a mean weight of 0.75 and more; those of a wrong one by chance to 0.3 to 0.55.
constexpr double kLeastColour = 0.35;
constexpr double kColourOfRightPlace = 0.75;

// Recorded poses are corrected by no more than this, unless the frame fits as frames usually do.
constexpr double kSmallCorrection_m = 0.05;
constexpr double kSmallCorrection_rad = 0.05;

// A pose far from where the camera was expected, or after a gap, or after the camera was lost, must fit as well as
// frames usually do: a wrong place would be fused as a second copy. At the right place a frame fits within these of the
// usual; at a wrong one it lacks a tenth of its inliers or colour, or the model contradicts it.
constexpr double kSureOverlap = 0.4;
constexpr double kSureInliers = 0.65;
constexpr double kSureColour = 0.5;
constexpr double kSureChanged = 0.1;
constexpr double kUsualInliers = 0.08;
constexpr double kUsualColour = 0.05;
constexpr double kUsualChanged = 0.03;

// Where something comes, goes or moves, the model contradicts a part of the frame in patches (scene_change.h); where
// the pose or the sensor is a little wrong, in strips. What the model does not contradict must agree with it as usual:
// else what moves takes the camera along.
constexpr double kChanged = 0.06;
constexpr double kInPatches = 0.7;  // of all that is contradicted
constexpr double kUsualRest = 0.06;
constexpr double kLeastInliersInChange = 0.3;
constexpr std::int64_t kPromptly_ns = 250'000'000;  // later than this another place is likelier than a change
constexpr int kMostUnsure = 15;                     // frames in a row that are only followed

// So far from where it was expected, and by more than the camera moved before, or after so many intervals without a
// frame, a pose is a surprise.
constexpr double kSurprise_m = 0.2;
constexpr double kSurprise_rad = 0.2;
constexpr double kSurpriseIntervals = 4;

// A fit that gets so much worse from one frame to the next is a surprise, too: who walks into view does so more slowly.
constexpr double kFallOfInliers = 0.25;
constexpr double kFallOfColour = 0.2;
constexpr double kRiseOfChange = 0.1;

// A place that was recognised must hold for so many frames in a row before anything is fused.
constexpr int kSureViews = 3;

// A view from elsewhere shows less of what the camera sees: look again from the place that was found.
constexpr double kNearView_m = 0.1;
constexpr double kNearView_rad = 0.1;

// Over a longer time than this since the last frame, the camera's mean motion says little of that while a frame is
// taken.
constexpr double kLongest_s = 0.15;

// No hand moves a camera faster: such frames are far apart, and what happened between them is not known.
constexpr double kQuickest_rad_s = 4;
constexpr double kQuickest_m_s = 2;

bool is_by_hand(const SteadyMotion& motion, double apart_s) {
  return motion.turn_rad.norm() < kQuickest_rad_s * std::abs(apart_s) &&
         motion.shift_m.norm() < kQuickest_m_s * std::abs(apart_s);
}

double seconds(std::int64_t time, const Frame& frame) {
  constexpr double kUsualRate_hz = 30;  // of recordings without a clock, whose time counts frames
  return static_cast<double>(time) * (frame.has_clock ? 1e-9 : 1 / kUsualRate_hz);
}

/// Why a frame shows too little to be tracked; nothing when it shows enough.
std::optional<TrackReason> why_blind(const SurfaceLevel& level, std::optional<double> last_depth_m) {
  const auto points = static_cast<double>(points_of(level));
  if (points == 0) return TrackReason::kNothingSeen;
  if (points >= kFewestPoints * level.intrinsics.width * level.intrinsics.height) return std::nullopt;
  return last_depth_m && *last_depth_m < kTooClose_m ? TrackReason::kTooClose : TrackReason::kTooFewPoints;
}

/// Of what the model does not contradict, the share that agrees with it.
double inliers_of_rest(double inlier_share, double contradicted_share) {
  return contradicted_share < 1 ? inlier_share / (1 - contradicted_share) : 0;
}

bool has_changed(const IcpResult& fit) {
  return fit.changed_share > kChanged && fit.changed_share > kInPatches * fit.contradicted_share;
}

bool is_believable(const IcpResult& fit, double least_inliers = kLeastInliers) {
  return fit.overlap >= kLeastOverlap && fit.inlier_share >= least_inliers && fit.colour_agreement >= kLeastColour;
}

bool is_near(const Pose& a, const Pose& b, double distance_m, double turn_rad) {
  const Pose apart = a.inverse() * b;
  return apart.translation().norm() < distance_m && angle_of(apart) < turn_rad;
}

/// Why a believable pose is held by little; nothing when it is held well.
std::optional<TrackReason> why_weak(const IcpResult& fit) {
  if (fit.weak_directions > 0) return TrackReason::kFlatScene;
  if (fit.inlier_share < kGoodInliers || has_changed(fit)) return TrackReason::kSceneHasChanged;
  if (fit.overlap < 2 * kLeastOverlap) return TrackReason::kLittleOverlap;
  return std::nullopt;
}

TrackResult describe(TrackState state, TrackReason reason, const Pose& T_world_camera, const IcpResult& fit) {
  TrackResult result;
  result.state = state;
  result.reason = reason;
  result.T_world_camera = T_world_camera;
  result.points = fit.points;
  result.overlap = fit.overlap;
  result.inlier_share = fit.inlier_share;
  result.contradicted_share = fit.contradicted_share;
  result.changed_share = fit.changed_share;
  result.colour_agreement = fit.colour_agreement;
  result.rms_sigma = fit.rms_sigma;
  result.weak_directions = fit.weak_directions;
  result.colour_later = fit.colour_later;
  return result;
}

}  // namespace

TrackResult ModelTracker::track(const Frame& frame, const TsdfVolume& volume) {
  volume_ = &volume;
  raycast_time_ = {};
  if (prior_ == PosePrior::kRefine && frame.T_world_camera) return track_new(frame);
  if (is_repeated(frame)) {
    TrackResult again = newest_->found;
    if (again.state == TrackState::kRecovered) again.state = TrackState::kOk;
    again.raycast_time = {};
    return again;
  }
  const TrackResult result = track_new(frame);
  newest_ = {frame.depth_m, frame.colour ? frame.colour->image : ColourImage(), result};
  return result;
}

/// Cameras and drivers that are late deliver the pictures of the frame before once more. They were taken at that
/// frame's time: a motion since then, with a shutter that rolls along it, would be wrong, and so would be the next.
bool ModelTracker::is_repeated(const Frame& frame) const {
  if (!newest_ || volume_->blocks() == 0 || frame.depth_m != newest_->depth_m) return false;
  return frame.colour ? frame.colour->image == newest_->colour : newest_->colour.empty();
}

TrackResult ModelTracker::track_new(const Frame& frame) {
  noise_ = volume_->config().noise.scaled(noise_scale_);
  apart_s_ = seconds_since_last(frame);
  moving_.reset();
  if (apart_s_ != 0) moving_ = moving_since(last_->T_world_camera, apart_s_, frame);
  SurfacePyramid seen = pyramid_of(frame, noise_, expected_to_colour(frame));
  const int unsure_before = unsure_frames_;
  TrackResult result = prior_ == PosePrior::kRefine && frame.T_world_camera ? refine(frame, seen) : follow(frame, seen);
  if (unsure_frames_ == unsure_before) unsure_frames_ = 0;
  result.rms_sigma *= noise_scale_;
  if (!result.is_lost()) forget_views();  // the frame will be fused
  if (!result.is_lost() && moving_) result.motion = motion_of(*moving_, apart_s_, result);
  remember(frame, seen, result);
  const bool has_moved = !last_moved_ || result.T_world_camera.matrix() != last_moved_->T_world_camera.matrix();
  if (!result.is_lost() && has_moved) last_moved_ = {result.T_world_camera, std::move(seen.levels.front())};
  result.raycast_time = raycast_time_;
  return result;
}

TrackResult ModelTracker::track_later(const Frame& frame, const TsdfVolume& volume,
                                      const std::optional<KnownFrame>& neighbour) {
  volume_ = &volume;
  raycast_time_ = {};
  noise_ = volume.config().noise.scaled(noise_scale_);
  apart_s_ = neighbour ? seconds(frame.timestamp_ns - neighbour->timestamp_ns, frame) : 0;
  const bool has_motion = apart_s_ != 0 && std::abs(apart_s_) <= kLongest_s;
  std::optional<MovingCamera> moving;
  if (has_motion) moving = moving_since(neighbour->T_world_camera, apart_s_, frame);
  const SurfacePyramid seen = pyramid_of(frame, noise_);
  IcpResult nothing;
  nothing.points = points_of(seen.levels.front());
  if (const auto blind = why_blind(seen.levels.front(), std::nullopt)) {
    return describe(TrackState::kLost, *blind, Pose::Identity(), nothing);
  }
  const auto found = neighbour ? sure_fit(seen, neighbour->T_world_camera, moving) : find_again(seen);
  if (!found) return describe(TrackState::kLost, TrackReason::kPlaceNotRecognised, Pose::Identity(), nothing);
  TrackResult result = describe(TrackState::kRecovered, TrackReason::kFoundLater, found->T_world_camera, found->icp);
  result.rms_sigma *= noise_scale_;
  forget_views();  // the frame will be fused
  if (moving) result.motion = motion_of(*moving, apart_s_, result);
  result.raycast_time = raycast_time_;
  return result;
}

TrackResult ModelTracker::follow(const Frame& frame, const SurfacePyramid& seen) {
  const Pose T_last = last_ ? last_->T_world_camera : frame.T_world_camera.value_or(Pose::Identity());
  IcpResult nothing;
  nothing.points = points_of(seen.levels.front());
  const auto blind = why_blind(seen.levels.front(), last_ ? std::optional(last_->depth_m) : std::nullopt);
  if (blind) return describe(TrackState::kLost, *blind, T_last, nothing);
  if (!last_ || volume_->blocks() == 0) return describe(TrackState::kOk, TrackReason::kNone, T_last, nothing);
  if (stands_still(seen)) return keep_pose(seen);

  if (recognised_) {
    const auto again = sure_fit(seen, recognised_->T_world_camera);
    if (again && recognised_->views + 1 >= kSureViews) {
      return describe(TrackState::kRecovered, TrackReason::kNone, again->T_world_camera, again->icp);
    }
    if (again) {
      recognised_ = Recognised{again->T_world_camera, recognised_->views + 1};
      return describe(TrackState::kLost, TrackReason::kMakingSure, T_last, again->icp);
    }
    recognised_.reset();
  }
  const Fit followed = follow_motion(seen, frame.timestamp_ns);
  if (is_accepted(followed, frame.timestamp_ns)) {
    learn_lateness(followed, seen);
    if (is_lost_) return describe(TrackState::kRecovered, TrackReason::kNone, followed.T_world_camera, followed.icp);
    const auto weak = why_weak(followed.icp);
    return describe(weak ? TrackState::kWeak : TrackState::kOk, weak.value_or(TrackReason::kNone),
                    followed.T_world_camera, followed.icp);
  }
  if (is_worth_following(followed, frame.timestamp_ns)) {
    ++unsure_frames_;
    return describe(TrackState::kLost, TrackReason::kSceneIsChanging, followed.T_world_camera, followed.icp);
  }
  if (const auto again = find_again(seen)) {
    recognised_ = Recognised{again->T_world_camera, 1};
    return describe(TrackState::kLost, is_lost_ ? TrackReason::kMakingSure : TrackReason::kTooFast, T_last, again->icp);
  }
  const TrackReason reason = is_lost_ ? TrackReason::kPlaceNotRecognised : TrackReason::kTooFast;
  return describe(TrackState::kLost, reason, T_last, followed.icp);
}

bool ModelTracker::stands_still(const SurfacePyramid& seen) const {
  if (!last_moved_ || last_moved_->level.intrinsics != seen.levels.front().intrinsics) return false;
  return scanknit::stands_still(seen.levels.front(), last_moved_->level, noise_);
}

/// The pose is that of the frame since which the camera stands still: directions that the scene does not determine
/// would slide, and take along with what moves.
TrackResult ModelTracker::keep_pose(const SurfacePyramid& seen) {
  const Model model = raycast_model(seen.levels.front().intrinsics, last_moved_->T_world_camera);
  IcpConfig config{noise_};
  config.keeps_pose = true;
  const IcpResult fit = register_frame(seen, model.pyramid, Pose::Identity(), config);
  const bool is_weak = fit.inlier_share < kGoodInliers || has_changed(fit);
  const TrackState state = is_lost_ ? TrackState::kRecovered : is_weak ? TrackState::kWeak : TrackState::kOk;
  return describe(state, state == TrackState::kWeak ? TrackReason::kSceneHasChanged : TrackReason::kNone,
                  model.T_world_camera, fit);
}

TrackResult ModelTracker::refine(const Frame& frame, const SurfacePyramid& seen) {
  const Pose& T_recorded = *frame.T_world_camera;
  auto moving = moving_;
  if (moving) moving->colour_sigma = 0;  // the motion to a wrong pose says nothing of the time of colour
  const Fit found = fit(seen, raycast_model(seen.levels.front().intrinsics, T_recorded), {T_recorded}, moving);
  if (volume_->blocks() == 0) return describe(TrackState::kOk, TrackReason::kNone, T_recorded, found.icp);
  const bool is_small = is_near(T_recorded, found.T_world_camera, kSmallCorrection_m, kSmallCorrection_rad);
  if (!is_sure(found.icp)) {
    const bool only_scene_changed = is_small && is_steady(found.icp);
    if (!only_scene_changed && found.icp.overlap >= kLeastOverlap && is_suddenly_worse(found.icp)) {
      return describe(TrackState::kLost, TrackReason::kRecordedPoseDoesNotFit, T_recorded, found.icp);
    }
    if (!is_small || !is_believable(found.icp) || has_changed(found.icp)) {
      return describe(TrackState::kWeak, TrackReason::kRecordedPoseKept, T_recorded, found.icp);
    }
  }
  const auto weak = why_weak(found.icp);
  return describe(weak ? TrackState::kWeak : TrackState::kOk, weak.value_or(TrackReason::kNone), found.T_world_camera,
                  found.icp);
}

/// Whether a pose that was followed is good enough to be fused.
bool ModelTracker::is_accepted(const Fit& fit, std::int64_t timestamp_ns) const {
  if (is_lost_ || is_elsewhere(fit, timestamp_ns)) return is_sure(fit.icp);
  if (has_changed(fit.icp) && knows_usual_quality()) {
    return is_steady(fit.icp) && (is_prompt(timestamp_ns) || !is_suddenly_worse(fit.icp));
  }
  if (is_suddenly_worse(fit.icp)) return is_sure(fit.icp);
  return is_believable(fit.icp) && (unsure_frames_ == 0 || is_as_usual(fit.icp));
}

/// Whether a pose that is not fused is good enough to go on from: something moves, which may take the camera along.
bool ModelTracker::is_worth_following(const Fit& fit, std::int64_t timestamp_ns) const {
  if (is_lost_ || is_elsewhere(fit, timestamp_ns) || !is_prompt(timestamp_ns)) return false;
  if (unsure_frames_ == kMostUnsure) return false;
  return has_changed(fit.icp) ? is_believable(fit.icp, kLeastInliersInChange)
                              : unsure_frames_ > 0 && is_believable(fit.icp);
}

bool ModelTracker::is_surprise(const Fit& fit, std::int64_t timestamp_ns) const {
  return is_elsewhere(fit, timestamp_ns) || is_suddenly_worse(fit.icp);
}

/// Not where the camera was expected, or nobody knows where to expect it.
bool ModelTracker::is_elsewhere(const Fit& fit, std::int64_t timestamp_ns) const {
  if (intervals_since_last(timestamp_ns) > kSurpriseIntervals) return true;
  const Pose moved = T_before_last_.value_or(Pose::Identity());
  return !is_near(predicted(timestamp_ns), fit.T_world_camera, std::max(kSurprise_m, moved.translation().norm()),
                  std::max(kSurprise_rad, angle_of(moved)));
}

/// Something has changed, and what has not fits as usual: nothing takes the camera along.
bool ModelTracker::is_steady(const IcpResult& fit) const {
  return has_changed(fit) && knows_usual_quality() && is_believable(fit, kLeastInliersInChange) &&
         fit.colour_agreement >= usual_.colour_agreement - kUsualColour &&
         inliers_of_rest(fit.inlier_share, fit.contradicted_share) >=
             inliers_of_rest(usual_.inlier_share, usual_.contradicted_share) - kUsualRest;
}

bool ModelTracker::is_sure(const IcpResult& fit) const {
  return fit.weak_directions == 0 && fit.overlap >= kSureOverlap && fit.inlier_share >= kSureInliers &&
         fit.colour_agreement >= kSureColour && fit.changed_share <= kSureChanged && is_as_usual(fit);
}

bool ModelTracker::is_as_usual(const IcpResult& fit) const {
  if (!knows_usual_quality()) return true;
  return fit.inlier_share >= usual_.inlier_share - kUsualInliers &&
         fit.colour_agreement >= std::min(usual_.colour_agreement - kUsualColour, kColourOfRightPlace) &&
         fit.changed_share <= usual_.changed_share + kUsualChanged;
}

bool ModelTracker::knows_usual_quality() const {
  constexpr int kFewest = 3;
  return usual_frames_ >= kFewest;
}

bool ModelTracker::is_suddenly_worse(const IcpResult& fit) const {
  return fit.inlier_share < last_quality_.inlier_share - kFallOfInliers ||
         fit.colour_agreement < last_quality_.colour_agreement - kFallOfColour ||
         fit.changed_share > last_quality_.changed_share + kRiseOfChange;
}

ModelTracker::Model ModelTracker::raycast_model(const CameraIntrinsics& camera, const Pose& T_world_camera) {
  const auto begin = std::chrono::steady_clock::now();
  const ModelView view = raycast(*volume_, camera, T_world_camera);
  raycast_time_ += std::chrono::steady_clock::now() - begin;
  return {T_world_camera, pyramid_of(view, noise_)};
}

/// The same places are looked at for each frame of a camera that is lost.
const ModelTracker::Model& ModelTracker::view_of_place(const CameraIntrinsics& camera, const Pose& T_world_place) {
  constexpr std::size_t kMost = 8;  // one frame's; 3 MB each for a camera of 640 x 480
  const auto seen = std::find_if(views_.begin(), views_.end(), [&](const View& view) {
    return view.camera == camera && view.model.T_world_camera.matrix() == T_world_place.matrix();
  });
  if (seen != views_.end()) {
    views_.splice(views_.begin(), views_, seen);
  } else {
    views_.push_front({camera, raycast_model(camera, T_world_place)});
    if (views_.size() > kMost) views_.pop_back();
  }
  return views_.front().model;
}

ModelTracker::Fit ModelTracker::fit(const SurfacePyramid& seen, const Model& model,
                                    const std::vector<Pose>& T_world_guesses,
                                    const std::optional<MovingCamera>& moving) {
  IcpConfig coarse{noise_};
  coarse.last_level = coarse.first_level;
  const Pose T_model_world = model.T_world_camera.inverse();
  coarse.moving = moving;
  if (moving) coarse.moving->T_model_before = T_model_world * moving->T_model_before;
  IcpResult best;
  best.support = -1;
  for (const Pose& guess : T_world_guesses) {
    const IcpResult tried = register_frame(seen, model.pyramid, T_model_world * guess, coarse);
    if (tried.support > best.support) best = tried;
  }
  IcpConfig fine{noise_};
  fine.moving = coarse.moving;
  fine.colour_later = best.colour_later;
  if (moving && moving->colour_sigma == 0 && prior_ == PosePrior::kIgnore) {
    fine.asks_if_colour_is_late = is_by_hand(fine.moving->motion(best.T_model_frame), apart_s_);
    fine.colour_is_timely = fine.asks_if_colour_is_late && lateness_.is_none();
  }
  fine.first_level = coarse.last_level - 1;
  const IcpResult found = register_frame(seen, model.pyramid, best.T_model_frame, fine);
  return {model.T_world_camera * found.T_model_frame, found};
}

ModelTracker::Fit ModelTracker::follow_motion(const SurfacePyramid& seen, std::int64_t timestamp_ns) {
  const Fit found = fit_near(seen, predicted(timestamp_ns));
  if (!is_surprise(found, timestamp_ns) || is_sure(found.icp)) return found;
  const Fit stayed = fit_near(seen, last_->T_world_camera);  // the camera may have stopped
  return stayed.icp.inliers() > found.icp.inliers() ? stayed : found;
}

/// Fits the frame to what is seen from `expected`, and again to what is seen from where that leads.
ModelTracker::Fit ModelTracker::fit_near(const SurfacePyramid& seen, const Pose& expected) {
  const Model model = raycast_model(seen.levels.front().intrinsics, expected);
  const Pose turned = expected * turn_by_shift(seen, model.pyramid);
  const Fit found = fit(seen, model, {last_->T_world_camera, expected, turned}, moving_);
  if (is_near(expected, found.T_world_camera, kNearView_m, kNearView_rad) || !is_believable(found.icp)) return found;
  return fit(seen, raycast_model(seen.levels.front().intrinsics, found.T_world_camera), {found.T_world_camera},
             moving_);
}

std::optional<ModelTracker::Fit> ModelTracker::sure_fit(const SurfacePyramid& seen, const Pose& T_world_place,
                                                        const std::optional<MovingCamera>& moving) {
  const CameraIntrinsics& camera = seen.levels.front().intrinsics;
  const Model& model = view_of_place(camera, T_world_place);
  const Fit first = fit(seen, model, {T_world_place, T_world_place * turn_by_shift(seen, model.pyramid)}, moving);
  if (!is_believable(first.icp)) return std::nullopt;
  const Fit second = fit(seen, raycast_model(camera, first.T_world_camera), {first.T_world_camera}, moving);
  return is_sure(second.icp) ? std::optional(second) : std::nullopt;
}

std::optional<ModelTracker::Fit> ModelTracker::find_again(const SurfacePyramid& seen) {
  std::optional<Fit> best;
  const auto keep_best = [&](const std::vector<Pose>& poses) {
    for (const Pose& place : poses) {
      const auto found = sure_fit(seen, place);
      if (found && (!best || found->icp.inliers() > best->icp.inliers())) best = found;
    }
  };
  keep_best(places_.similar_poses(seen));
  if (!best) keep_best(places_.matched_poses(seen));
  return best;
}

bool ModelTracker::is_prompt(std::int64_t timestamp_ns) const {
  return std::abs(timestamp_ns - last_->timestamp_ns) <= kPromptly_ns;
}

double ModelTracker::intervals_since_last(std::int64_t timestamp_ns) const {
  return interval_ns_ != 0 ? static_cast<double>(timestamp_ns - last_->timestamp_ns) / static_cast<double>(interval_ns_)
                           : 1;
}

/// Negative where frames come in reverse order; 0 where the camera's motion since then is not known, or says nothing of
/// the frame.
double ModelTracker::seconds_since_last(const Frame& frame) const {
  if (!last_ || is_lost_) return 0;
  const double since_s = seconds(frame.timestamp_ns - last_->timestamp_ns, frame);
  return std::abs(since_s) <= kLongest_s ? since_s : 0;
}

/// As the camera moved between the last two frames.
SteadyMotion ModelTracker::expected_to_colour(const Frame& frame) const {
  if (!frame.colour || !T_before_last_ || seconds_since_last(frame) == 0) return {};
  const double interval_s = seconds(interval_ns_, frame);
  if (interval_s == 0 || std::abs(interval_s) > kLongest_s) return {};
  return SteadyMotion::from(*T_before_last_) * (timing_.colour_later_s / interval_s);
}

/// As the camera moved from one pose to the other in `apart_s`, which is negative where the frame came first.
MovingCamera ModelTracker::moving_since(const Pose& T_world_other, double apart_s, const Frame& frame) const {
  constexpr double kColourSigma_s = 0.01;  // the time of colour varies by so much from frame to frame
  const double colour_sigma = searches_colour_time(timing_, frame) ? kColourSigma_s / std::abs(apart_s) : 0;
  return {T_world_other, timing_.readout_s / apart_s, colour_sigma};
}

FrameMotion ModelTracker::motion_of(const MovingCamera& moving, double apart_s, const TrackResult& result) const {
  const SteadyMotion motion = moving.motion(result.T_world_camera);
  return {motion * moving.readout, motion * (timing_.colour_later_s / apart_s + result.colour_later)};
}

Pose ModelTracker::predicted(std::int64_t timestamp_ns) const {
  constexpr double kFarthest = 12;  // intervals: so long after, nothing is known of a motion
  const double intervals = intervals_since_last(timestamp_ns);
  if (!T_before_last_ || !(intervals > 0 && intervals <= kFarthest)) return last_->T_world_camera;
  const Eigen::AngleAxisd turn(T_before_last_->linear());
  Pose motion = Pose::Identity();
  motion.linear() = Eigen::AngleAxisd(turn.angle() * intervals, turn.axis()).toRotationMatrix();
  motion.translation() = T_before_last_->translation() * intervals;
  return last_->T_world_camera * motion;
}

void ModelTracker::learn_lateness(const Fit& followed, const SurfacePyramid& seen) {
  if (!followed.icp.colour_seems_later) return;
  const SteadyMotion motion = moving_->motion(followed.T_world_camera);
  const double moved_px = motion.pixels(seen.levels.front().intrinsics, last_->depth_m);
  lateness_.learn(*followed.icp.colour_seems_later * apart_s_, moved_px);
}

void ModelTracker::remember(const Frame& frame, const SurfacePyramid& seen, const TrackResult& result) {
  is_lost_ = result.is_lost() && unsure_frames_ == 0;
  if (is_lost_) {
    T_before_last_.reset();
    return;
  }
  recognised_.reset();
  if (last_ && result.state != TrackState::kRecovered) {
    T_before_last_ = last_->T_world_camera.inverse() * result.T_world_camera;
    interval_ns_ = frame.timestamp_ns - last_->timestamp_ns;
  }
  last_ = Known{result.T_world_camera, frame.timestamp_ns, median_depth_m(seen.levels.back())};
  learn_quality(result);
  if (result.state == TrackState::kOk || result.state == TrackState::kRecovered)
    places_.learn(seen, result.T_world_camera);
}

void ModelTracker::learn_quality(const TrackResult& result) {
  if (!(result.inlier_share >= kLeastInliers)) return;  // nothing to compare with
  last_quality_ = {result.inlier_share, result.colour_agreement, result.contradicted_share, result.changed_share};
  if (result.state != TrackState::kOk) return;
  constexpr double kSlowly = 0.1;
  const double rate = std::max(kSlowly, 1.0 / ++usual_frames_);
  const auto follow = [&](double& usual, double newest) { usual += rate * (newest - usual); };
  follow(usual_.inlier_share, last_quality_.inlier_share);
  follow(usual_.colour_agreement, last_quality_.colour_agreement);
  follow(usual_.contradicted_share, last_quality_.contradicted_share);
  follow(usual_.changed_share, last_quality_.changed_share);
  constexpr double kNoisiest = 4;
  noise_scale_ = std::clamp(noise_scale_ + kSlowly * (result.rms_sigma - noise_scale_), 1.0, kNoisiest);
}

}  // namespace scanknit
