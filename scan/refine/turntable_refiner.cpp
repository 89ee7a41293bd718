#include "scan/refine/turntable_refiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "acquire/filter/depth_filter.h"
#include "core/median.h"
#include "core/rotation.h"
#include "fusion/picture_part.h"
#include "fusion/turntable/cut_volume.h"
#include "scan/frames/frame_count.h"

namespace scanknit {
namespace {

constexpr std::size_t kSamples = 48;  // frames that show what stands still, and what they see through
constexpr std::size_t kFewestTracked = 4;
constexpr std::size_t kFewestFrames = 8;  // frames with a common motion
constexpr double kLeastTurn_rad = 30 * kDegree;
constexpr double kAcross_rad = std::numbers::pi * 1.05;  // a pair farther apart than this closes the turn
constexpr double kMostOff = 0.05;  // of the object's distance: most that tracked poses may deviate from one axis
constexpr double kMostRms_m = 0.004;
constexpr double kLeastAgreeing = 0.6;  // share of pairs of frames that agree
constexpr double kAgrees = 0.3;         // a pair agrees when its weight is above this
constexpr double kHeld_rad = 0.3 * kDegree;
constexpr double kSeen_rad = 0.5 * kDegree;  // error of the pictures' angles within a turn
constexpr double kPlaces_rad = 3 * kDegree;  // known angles with less error join parts without common pairs
constexpr double kLeastInSequence = 0.6;     // share of key frames that fit the one before
constexpr double kUnderDisc_m = 0.006;
constexpr double kOverDisc_m = 0.004;  // the disc looks the same at all angles, so it does not help to find them

double extent_of(const std::vector<double>& angles_rad) {
  const auto [least, most] = std::minmax_element(angles_rad.begin(), angles_rad.end());
  return *most - *least;
}

double extent_of(const std::vector<double>& angles_rad, const std::set<std::size_t>& nodes) {
  const auto [least, most] = std::minmax_element(
      nodes.begin(), nodes.end(), [&](std::size_t a, std::size_t b) { return angles_rad[a] < angles_rad[b]; });
  return nodes.empty() ? 0 : angles_rad[*most] - angles_rad[*least];
}

}  // namespace

std::optional<std::size_t> TurntableRefiner::Nodes::find(std::uint64_t sequence) const {
  const auto at = std::lower_bound(sequences.begin(), sequences.end(), sequence);
  if (at == sequences.end() || *at != sequence) return std::nullopt;
  return static_cast<std::size_t>(at - sequences.begin());
}

TurntableRefiner::TurntableRefiner(const ScanJob& job, PoseMode poses, const FrameArchive& archive,
                                   ScanSession& session)
    : job_(job), config_(job.config), has_poses_(!is_tracked(poses)), archive_(archive), session_(session) {}

bool TurntableRefiner::give_up(const char* reason) {
  result_.reason = reason;
  session_.warn(WarningCode::kNoTurntable,
                fmt::format("no turntable: {}; the mesh is {}{}", reason,
                            has_poses_ ? "as the recording's poses have it, and nothing was cut" : "the tracked one",
                            job_.cut_recording ? ", and no cut recording was written" : ""));
  return false;
}

/// Calls `visit` with every `every`-th of the job's frames.
Result<void> TurntableRefiner::read_frames(std::size_t every, const Visit& visit) const {
  const auto source = archive_.open(every);
  if (!source) return source.error();
  return for_each_frame(**source, session_.stop(), [&](Frame& frame) -> Result<Reading> {
    if (auto visited = visit(frame); !visited) return visited.error();
    return Reading::kContinue;
  });
}

void TurntableRefiner::add_sample(Frame& frame) {
  if (!samples_.empty() && !(frame.intrinsics == camera_)) return;
  camera_ = frame.intrinsics;
  const AcquireConfig& filter = config_.acquire;
  samples_.push_back(
      mask_discontinuities(clip_range(frame.depth_m, filter.min_depth_m.value_or(0), filter.max_depth_m.value_or(0)),
                           config_.fusion.noise, filter.edge_sigmas));
  sample_sequences_.push_back(frame.sequence);
}

Result<void> TurntableRefiner::prepare() {
  const auto source = archive_.open();
  if (!source) return source.error();
  if (auto checked = check_known_angles((*source)->info()); !checked) return checked;
  const std::size_t selected = selected_frames((*source)->info(), config_.acquire);
  const std::size_t frames = std::min(selected, archive_.most_frames());
  const std::size_t every = std::max<std::size_t>(1, (frames + kSamples - 1) / kSamples);
  const auto begun = session_.timed("refine", [&] {
    const std::size_t to_read = (frames + every - 1) / every;
    std::size_t read_so_far = 0;
    auto read = read_frames(every, [&](Frame& frame) -> Result<void> {
      session_.progress("learning what stands still", std::min(++read_so_far, to_read), to_read);
      add_sample(frame);
      return {};
    });
    if (read && read_so_far < to_read && !session_.is_stopped()) {
      warn(fmt::format("{} of {} frames from which to learn what stands still could not be read", to_read - read_so_far,
                       to_read));
    }
    still_ = StillScene::learn(samples_, config_.fusion.noise);
    const std::vector<DepthImage> moving = moving_parts();
    if (const double depth_m = median_depth_m(moving); depth_m > 0) depth_m_ = depth_m;
    if (changes_frames()) moving_rect_ = rect_of(moving);
    return read;
  });
  result_.has_still_scene = !still_.empty();
  is_prepared_ = begun.has_value();
  return begun;
}

/// Checks the known angles before any work. Errors: kConfig.
Result<void> TurntableRefiner::check_known_angles(const RecordingInfo& info) {
  auto known = KnownAngles::read(job_);
  if (!known) return known.error();
  known_ = *std::move(known);
  const auto warning = known_.check(info);
  if (!warning) return warning.error();
  if (*warning) warn(**warning);
  if (has_poses_ && known_.source() != AngleSource::kNone) {
    warn(fmt::format("the poses of the recording are used, not {} (acquire.poses=track uses it)", known_.option()));
  }
  return {};
}

std::vector<DepthImage> TurntableRefiner::moving_parts() const {
  std::vector<DepthImage> parts = samples_;
  for (DepthImage& part : parts) still_.remove_from(part);
  return parts;
}

void TurntableRefiner::edit_for_tracking(Frame& frame) const {
  if (!changes_frames() || !(frame.intrinsics == camera_)) return;
  still_.remove_from(frame.depth_m);
  if (moving_rect_) crop_frame(frame, *moving_rect_);
}

/// Finds first angles of all frames, from the poses of those that were tracked.
bool TurntableRefiner::begin_nodes(const TrackedWalk& walk) {
  if (walk.trajectory.size() < kFewestTracked) return give_up("too few frames were tracked");
  std::vector<Pose> poses;
  std::vector<std::uint64_t> tracked;
  for (const PosedFrame& frame : walk.trajectory) {
    poses.push_back(frame.T_world_camera);
    tracked.push_back(frame.sequence);
  }
  const auto fitted = fit_turntable(poses, depth_m_);
  if (!fitted) return give_up("nothing turns before the scanner");
  if (median(distances_from(*fitted, poses, depth_m_)) > kMostOff * depth_m_)
    return give_up("the motion is not about one axis");
  if (has_poses_) {
    nodes_.sequences = tracked;
    nodes_.motion = *fitted;
    nodes_.T_world_camera = poses;
    for (const PosedFrame& frame : walk.trajectory) nodes_.stamps.push_back(frame.stamp);
    return true;
  }
  nodes_.motion.axis = fitted->axis;
  for (const TrackedFrame& frame : walk.tracking->frames) {
    nodes_.sequences.push_back(frame.sequence);
    nodes_.is_tracked.push_back(std::binary_search(tracked.begin(), tracked.end(), frame.sequence));
  }
  nodes_.motion.angles_rad = angles_of_all(nodes_.sequences, tracked, fitted->angles_rad);
  nodes_.stamps.resize(nodes_.sequences.size());
  nodes_.times_ns.resize(nodes_.sequences.size());
  return true;
}

/// Finds the space of the object, and its rectangle in the picture.
bool TurntableRefiner::find_space_of_object() {
  const std::vector<DepthImage> moving = moving_parts();
  space_ = find_space(moving, still_, camera_, nodes_.motion.axis);
  if (!space_) return give_up("nothing moves before the scanner");
  const double to_axis_m = space_->distance_of(Eigen::Vector3d::Zero());
  if (space_->radius_m > to_axis_m) return give_up("the scanner moves, not the object");
  std::vector<DepthImage> kept = samples_;
  for (DepthImage& picture : kept) cut_to_space(picture, camera_, *space_, kUnderDisc_m);
  space_rect_ = rect_of(kept);
  return space_rect_ ? true : give_up("nothing moves before the scanner");
}

Result<void> TurntableRefiner::measure_pairs(TurntablePairs& pairs) {
  return read_frames(1, [&](Frame& frame) -> Result<void> {
    const auto node = nodes_.find(frame.sequence);
    if (!node) return {};
    if (frame.has_clock) nodes_.times_ns[*node] = frame.timestamp_ns;
    nodes_.stamps[*node] = stamp_of(frame);
    if (!(frame.intrinsics == camera_)) return {};
    if (auto filtered = filter_frame(frame, config_.acquire, config_.fusion.noise); !filtered) return filtered;
    cut_to_space(frame.depth_m, camera_, *space_, space_->disc_m ? -kOverDisc_m : kUnderDisc_m);
    crop_frame(frame, *space_rect_);
    pairs.add(*node, pyramid_of(frame, config_.fusion.noise));
    session_.progress("registering", *node + 1, nodes_.sequences.size());
    return {};
  });
}

/// Corrects the known angles by the pictures. Where the scene determines the angle, the pictures decide.
std::optional<AnglePrior> TurntableRefiner::checked_prior(AnglePrior prior, const TurntableSolution& seen,
                                                          const std::vector<std::size_t>& parts) {
  const bool is_held = seen.angle_sigma_rad < kHeld_rad && seen.rms_m <= kMostRms_m;
  if (!is_held) return prior;
  const bool has_several_parts = std::any_of(parts.begin(), parts.end(), [&](std::size_t part) {
    return part != 0 && std::count(parts.begin(), parts.end(), part) > 1;
  });
  if (has_several_parts && !known_.knows_gaps()) {
    warn(fmt::format("{} is not used: frames are missing, and it does not say how far the table turned meanwhile",
                     known_.option()));
    return std::nullopt;
  }
  const double tolerance_rad = 3 * std::hypot(prior.sigma_rad, kSeen_rad);
  const PriorCheck check = check_prior(prior.angles_rad, seen.motion, parts, tolerance_rad);
  if (check.contradicts) {
    warn(known_.contradiction(check));
    return std::nullopt;
  }
  std::vector<std::uint64_t> off;
  for (const std::size_t node : check.off) off.push_back(nodes_.sequences[node]);
  if (!off.empty()) warn(known_.frames_off(off));
  prior.angles_rad = check.agreed_angles_rad;
  return prior;
}

/// Warns of frames that nothing joins to the rest, if they are more than a few.
void TurntableRefiner::warn_of_left_out(const std::set<std::size_t>& solved) {
  constexpr std::size_t kFew = 20;  // one in so many
  std::vector<std::uint64_t> left_out;
  for (std::size_t i = 0; i < nodes_.sequences.size(); ++i) {
    if (!solved.contains(i)) left_out.push_back(nodes_.sequences[i]);
  }
  if (kFew * left_out.size() <= nodes_.sequences.size()) return;
  warn(fmt::format(
      "turntable: only {} of {} frames fit together; {} are left out, because no frame joins them to the rest: they "
      "show too little, or the table turned too far just before or after them. Turn it in steps of 2 to 8 degrees{}",
      solved.size(), nodes_.sequences.size(), frames_text(left_out), job_.angles ? "" : ", or give the angles"));
}

void TurntableRefiner::describe_solution(const TurntableSolution& solution, const TurntablePairs& pairs) {
  result_.turns = extent_of(solution.motion.angles_rad) / (2 * std::numbers::pi);
  result_.rms_m = solution.rms_m;
  result_.rms_rad = solution.rms_rad;
  result_.angle_sigma_rad = solution.angle_sigma_rad;
  result_.is_angle_held = solution.angle_sigma_rad < kHeld_rad;
  result_.key_frames = pairs.key_frames();
  result_.pairs = pairs.edges().size();
  result_.loops = pairs.loops();
  result_.across = pairs.across();
}

/// False when the frames show that it is no turntable.
bool TurntableRefiner::check_solution(const TurntableSolution& solution, const TurntablePairs& pairs) {
  const auto agreeing =
      std::count_if(solution.weights.begin(), solution.weights.end(), [](double weight) { return weight > kAgrees; });
  if (pairs.edges().empty()) return give_up("frames do not fit each other");
  if (static_cast<double>(agreeing) < kLeastAgreeing * static_cast<double>(pairs.edges().size())) {
    return give_up("frames contradict each other");
  }
  if (solution.rms_m > kMostRms_m) return give_up("the motion is not about one axis");
  if (extent_of(solution.motion.angles_rad) < kLeastTurn_rad) return give_up("it turns by less than 30 degrees");
  return true;
}

/// Adds the sampled frames, with the background, as witnesses of free space; their angles are known now.
void TurntableRefiner::add_witnesses() {
  look_through_.emplace(nodes_.motion.axis, config_.fusion.noise);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const auto node = nodes_.find(sample_sequences_[i]);
    if (node) look_through_->add_witness(std::move(samples_[i]), camera_, nodes_.motion.angles_rad[*node]);
  }
  samples_.clear();
}

/// To be called before the filter, which would take the rims of the cut for rims of the object.
void TurntableRefiner::cut_to_object(Frame& frame, double angle_rad) {
  const AcquireConfig& filter = config_.acquire;
  frame.depth_m =
      mask_discontinuities(clip_range(frame.depth_m, filter.min_depth_m.value_or(0), filter.max_depth_m.value_or(0)),
                           config_.fusion.noise, filter.edge_sigmas);
  cut_to_space(frame.depth_m, camera_, *space_, kUnderDisc_m);
  result_.pixels_looked_through += look_through_->remove_from(frame.depth_m, camera_, angle_rad);
}

/// Writes a frame without the disc: when the object lies on another side, the disc is at another place.
Result<void> TurntableRefiner::record_cut(const Frame& frame) {
  Frame cut = frame;
  cut.T_world_camera = poses_.at(frame.sequence);
  if (space_->disc_m && frame.intrinsics == camera_) cut_to_space(cut.depth_m, camera_, *space_, -kOverDisc_m);
  return cut_recording_->write(cut);
}

void TurntableRefiner::edit_for_fusion(Frame& frame) {
  const bool is_known_camera = frame.intrinsics == camera_;
  const auto node = nodes_.find(frame.sequence);
  if (node && is_known_camera && config_.turntable.cuts) cut_to_object(frame, nodes_.motion.angles_rad[*node]);
  if (cut_recording_ && recorded_) recorded_ = record_cut(frame);
  if (is_known_camera) crop_frame(frame, *space_rect_);
}

/// The refined poses of these nodes. Also sets T_world_object_ and poses_.
Trajectory TurntableRefiner::trajectory_of(const std::set<std::size_t>& solved) {
  // The object's frame is that of the first frame's camera.
  T_world_object_ =
      has_poses_ ? nodes_.T_world_camera.front() : T_table_camera(*space_, config_.fusion.voxel_size_m / 2);
  Trajectory trajectory;
  for (const std::size_t node : solved) {
    const double angle_rad = nodes_.motion.angles_rad[node];
    const Pose pose =
        has_poses_ ? nodes_.T_world_camera[node] : T_world_object_ * turn_about(nodes_.motion.axis, angle_rad);
    trajectory.push_back({nodes_.sequences[node], nodes_.stamps[node], pose});
    result_.angles_rad.emplace_back(nodes_.sequences[node], angle_rad);
  }
  poses_ = poses_of(trajectory);
  return trajectory;
}

Result<void> TurntableRefiner::accept(TsdfVolume& volume) {
  if (cut_recording_ && recorded_) recorded_ = cut_recording_->finish();
  if (!recorded_) return recorded_;
  has_cut_recording_ = cut_recording_.has_value();
  if (config_.turntable.cuts) {
    const VolumeCut cut = session_.timed(
        "refine", [&] { return cut_volume(moved(*space_, T_world_object_), config_.turntable.closes_base, volume); });
    result_.has_base = cut.has_base;
  }
  result_.is_refined = true;
  return {};
}

std::function<bool(const Eigen::Vector3d&)> TurntableRefiner::kept_space() const {
  if (!result_.is_refined || !config_.turntable.cuts) return {};
  return [this, space = moved(*space_, T_world_object_)](const Eigen::Vector3d& p) {
    return is_kept(space, config_.fusion, p);
  };
}

Result<void> TurntableRefiner::reject(const Result<std::size_t>& fused) {
  if (!fused) return fused.error();
  (void)give_up("it was interrupted");
  return {};
}

RefinerResult TurntableRefiner::result() const {
  RefinerResult result{.turntable = result_};
  if (is_prepared_ && !result_.is_refined && result_.reason.empty()) {
    result.turntable->reason =
        session_.is_stopped() ? "it was interrupted" : "the scan failed before the turntable was refined";
  }
  if (has_cut_recording_) result.files["cut_recording"] = job_.cut_recording->string();
  return result;
}

/// Finds the pairs of frames that fit each other; false: too few.
Result<bool> TurntableRefiner::find_pairs(TurntablePairs& pairs) {
  if (auto measured = measure_pairs(pairs); !measured) return measured.error();
  if (session_.is_stopped()) return give_up("it was interrupted");
  pairs.close();
  if (pairs.edges().empty()) return give_up("frames do not fit each other");
  if (pairs.share_in_sequence() < kLeastInSequence) return give_up("successive frames share too little of the surface");
  const TurntableMotion start = along_pairs(nodes_.motion, pairs.edges());
  const TurntableSolution seen = solve_turntable(start, pairs.edges(), std::nullopt);
  pairs.remove(backward_jumps(seen.motion, pairs.edges(), nodes_.is_tracked));
  nodes_.motion = along_pairs(seen.motion, pairs.edges());
  return true;
}

/// Joins the parts that no pair of frames joins, by the known angles alone; no picture can contradict these.
void TurntableRefiner::join_by_angles(std::vector<std::size_t>& parts) {
  std::vector<std::uint64_t> joined;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] != 0 && std::count(parts.begin(), parts.end(), parts[i]) > 1) joined.push_back(nodes_.sequences[i]);
  }
  std::fill(parts.begin(), parts.end(), std::size_t{0});
  if (joined.empty()) return;
  warn(fmt::format("turntable: {} are joined to the rest by {} alone; the pictures do not show their angles",
                   frames_text(joined), known_.option()));
}

/// Finds the axis and all angles; `solved` gets the nodes whose angles are right.
Result<bool> TurntableRefiner::find_motion(std::set<std::size_t>& solved) {
  TurntablePairs pairs(nodes_.motion, config_.fusion.noise);
  if (const auto found = find_pairs(pairs); !found || !*found) return found;
  const TurntableSolution seen = solve_turntable(nodes_.motion, pairs.edges(), std::nullopt);
  auto angles = known_.of(nodes_.sequences, nodes_.times_ns, seen.motion);
  if (!angles) return angles.error();
  std::vector<std::size_t> parts = turntable_parts(seen, pairs.edges(), kAgrees);
  std::optional<AnglePrior> prior;
  if (*angles) prior = checked_prior(**std::move(angles), seen, parts);
  result_.prior = prior ? known_.source() : AngleSource::kNone;
  if (prior && known_.knows_gaps() && prior->sigma_rad < kPlaces_rad) join_by_angles(parts);
  const TurntableSolution first = prior ? solve_turntable(nodes_.motion, pairs.edges(), prior) : seen;
  pairs.join_across(first.motion, parts);
  const TurntableSolution solution = solve_turntable(first.motion, pairs.edges(), prior);
  describe_solution(solution, pairs);
  if (!check_solution(solution, pairs)) return false;
  nodes_.motion = solution.motion;
  for (std::size_t i = 0; i < pairs.edges().size(); ++i) {
    const TurntableEdge& edge = pairs.edges()[i];
    if (solution.weights[i] <= kAgrees || parts[edge.from] != 0) continue;
    solved.insert({edge.from, edge.to});
    const double apart_rad = nodes_.motion.angles_rad[edge.to] - nodes_.motion.angles_rad[edge.from];
    result_.is_closed = result_.is_closed || std::abs(apart_rad) > kAcross_rad;
  }
  if (solved.size() < kFewestFrames) return give_up("too few frames fit together");
  result_.turns = extent_of(nodes_.motion.angles_rad, solved) / (2 * std::numbers::pi);
  warn_of_left_out(solved);
  // Found again, because the axis is known better now.
  return find_space_of_object();
}

/// Finds the motion and returns the nodes whose angles are right; none when it is no turntable.
Result<std::set<std::size_t>> TurntableRefiner::solved_frames() {
  std::set<std::size_t> solved;
  if (has_poses_) {
    for (std::size_t i = 0; i < nodes_.sequences.size(); ++i) solved.insert(solved.end(), i);
    result_.prior = AngleSource::kRecording;
    result_.turns = std::abs(nodes_.motion.angles_rad.back()) / (2 * std::numbers::pi);
    return solved;
  }
  const auto found = session_.timed("refine", [&] { return find_motion(solved); });
  if (!found) return found.error();
  return *found ? solved : std::set<std::size_t>();
}

Result<std::optional<Trajectory>> TurntableRefiner::refine(const TrackedWalk& walk) {
  const std::optional<Trajectory> as_tracked;
  if (session_.is_stopped()) return (void)give_up("it was interrupted"), as_tracked;
  const bool has_begun = session_.timed("refine", [&] { return begin_nodes(walk) && find_space_of_object(); });
  if (!has_begun) return as_tracked;
  const auto solved = solved_frames();
  if (!solved) return solved.error();
  if (solved->empty()) return as_tracked;
  result_.axis_direction = space_->up;
  result_.axis_point = space_->axis.point;
  result_.disc_m = space_->disc_m;
  result_.radius_m = space_->radius_m;
  add_witnesses();
  if (job_.cut_recording) {
    auto created = CutRecording::create(*job_.cut_recording);
    if (!created) return created.error();
    cut_recording_.emplace(*std::move(created));
  }
  return std::optional(trajectory_of(*solved));
}

}  // namespace scanknit
