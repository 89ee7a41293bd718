#include "fusion/loops/loop_closure.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "fusion/loops/key_frame_match.h"
#include "fusion/loops/pose_graph.h"

namespace scanknit {
namespace {

// Key frames nearer to each other than this along the walk are no loop: so many steps, and the camera has walked this
// many times the depth that it sees, or turned so far.
constexpr std::size_t kFewestSteps = 4;
constexpr double kFewestDepths = 1.5;
constexpr double kLeastTurn_rad = 1.5;

// Pairs tried for each key frame: those that would overlap most, and those that look most alike.
constexpr std::size_t kMostByPlace = 3;
constexpr std::size_t kMostByLooks = 2;
constexpr double kMostDissimilar = 0.2;
constexpr double kLeastExpectedOverlap = 0.35;

// A walk drifts by no more than this: 3 % and 0.8 degrees a metre were measured at the worst, in bare corridors.
constexpr double kDrift_m = 0.10;
constexpr double kDriftPerMetre = 0.06;
constexpr double kDrift_rad = 0.06;
constexpr double kDriftRadPerMetre = 0.02;
constexpr double kDriftRadPerRad = 0.03;
constexpr double kDriftOfGap_m = 0.5;
constexpr double kDriftOfGap_rad = 0.3;

// Tracking's error over a step between key frames, one standard deviation, in a scene that constrains all motions ...
constexpr double kStep_m = 0.001;
constexpr double kStepPerMetre = 0.005;
constexpr double kStep_rad = 0.0005;
constexpr double kStepRadPerRad = 0.005;
constexpr double kStepRadPerMetre = 0.001;
// ... plus this share of the covariance of two registered frames, whose information is at least kLeastHeld.
constexpr double kModelShare = 1;
constexpr double kLeastHeld = 10;  // 1 / m^2

// A step counts as mistracked when its two frames contradict it by so much, and with it so many key frames around it.
// Where tracking jumped onto an old surface (docs/loop_closure.md, gallery, seed 1) it was off by 4 % of the depth.
// What no sigma knows, a real sensor's bias and shutter, is mostly less than half of that.
constexpr double kMistrackedSigmas = 2;
constexpr double kMistrackedDepths = 0.02;
constexpr std::size_t kMistrackedBefore = 6;
constexpr std::size_t kMistrackedAfter = 5;

constexpr std::size_t kNeighbours = 3;  // key frames back, registered with each other

// Two loops agree when the cycle of both closes within this.
constexpr std::size_t kNearLoop = 6;  // key frames
constexpr double kCycle_m = 0.03;
constexpr double kCyclePerMetre = 0.02;
constexpr double kCycle_rad = 0.03;

constexpr double kLeastWeight = 0.1;  // in the pose graph, of a loop that is believed
constexpr double kMostStretched = 8;  // sigmas of a step that tracking knew

/// Calls find(n), which returns a list, for each n from `first` to `end` - 1, several at once. Returns all lists as
/// one, in the order of n.
template <typename Found, typename Find>
std::vector<Found> find_for_each(std::size_t first, std::size_t end, const Find& find) {
  std::vector<std::vector<Found>> by_number(end);
  tbb::parallel_for(first, end, [&](std::size_t number) { by_number[number] = find(number); });
  std::vector<Found> all;
  for (auto& found : by_number) std::move(found.begin(), found.end(), std::back_inserter(all));
  return all;
}

/// How far two motions put a point at this depth from each other.
double shift_m(const Pose& a, const Pose& b, double depth_m) {
  const Pose apart = a.inverse() * b;
  return apart.translation().norm() + depth_m * angle_of(apart);
}

struct Candidate {
  std::size_t a, b;  ///< key frames, a before b
  KeyFrameMatch match;
  std::string refused = {};
};

class Closer {
 public:
  Closer(const KeyFrames& frames, const IcpConfig& registration)
      : keys_(frames.kept()), walk_(frames.walk()), registration_(registration) {
    for (const KeyFrame& key : keys_) poses_.push_back(key.T_world_camera);
  }

  LoopClosure close(double tolerance_m) {
    LoopClosure closure;
    closure.T_world_cameras = walk_;
    if (keys_.size() <= kFewestSteps) return closure;
    measure_steps();
    follow_steps();
    closure.mistracked = mistracked();
    constexpr int kRounds = 2;
    bool is_borne_out = true;  // what the second round does not bear out was wrong
    for (int round = 0; round < kRounds && is_borne_out; ++round) {
      find_candidates();
      refuse_lonely();
      if (round == 0 && has_believed()) join_neighbours();
      is_borne_out = has_believed() && distribute();
    }
    closure.is_corrected = is_borne_out && largest_shift_m() > tolerance_m;
    if (closure.is_corrected) correct_walk(closure);
    describe(closure);
    return closure;
  }

 private:
  [[nodiscard]] Pose tracked(std::size_t a, std::size_t b) const {
    return keys_[a].T_world_camera.inverse() * keys_[b].T_world_camera;
  }
  [[nodiscard]] Pose stepped(std::size_t a, std::size_t b) const { return stepped_[a].inverse() * stepped_[b]; }
  [[nodiscard]] Pose now(std::size_t a, std::size_t b) const { return poses_[a].inverse() * poses_[b]; }

  /// From each key frame to the next as tracked, or across a gap as the two frames themselves have it.
  void measure_steps() {
    std::vector<std::optional<KeyFrameMatch>> matches(keys_.size());  // of each key frame with the one before it
    tbb::parallel_for(std::size_t{1}, keys_.size(), [&](std::size_t b) {
      matches[b] = match_key_frames(keys_[b - 1], keys_[b], {tracked(b - 1, b)}, registration_, Determined::kAny);
    });
    for (std::size_t b = 1; b < keys_.size(); ++b) {
      const std::size_t a = b - 1;
      const auto& seen = matches[b];
      PoseEdge step{a, b, tracked(a, b), step_information(tracked(a, b), seen), false};
      const bool has_gap = keys_[b].path.gaps > keys_[a].path.gaps;
      if (has_gap && seen) step = {a, b, seen->T_a_b, seen->information, false};
      if (has_gap && !seen) {
        step.information = Matrix6d::Identity();  // found again, somewhere: a metre and a radian
        step.may_be_wrong = true;
      }
      steps_.push_back(step);
      is_mistracked_.push_back(!has_gap && seen && contradicts(*seen, step));
    }
  }

  /// Registers each key frame with the few before it: together they constrain the walk better than single steps do.
  void join_neighbours() {
    neighbours_ = find_for_each<PoseEdge>(1, keys_.size(), [this](std::size_t b) {
      std::vector<PoseEdge> edges;
      for (std::size_t a = b - std::min(b, kNeighbours); a < b; ++a) {
        if (keys_[b].path.gaps > keys_[a].path.gaps) continue;
        const auto match = match_key_frames(keys_[a], keys_[b], {stepped(a, b)}, registration_);
        if (match) edges.push_back({a, b, match->T_a_b, match->information, true});
      }
      return edges;
    });
  }

  /// True when the registration of two frames contradicts the tracked step between them.
  [[nodiscard]] bool contradicts(const KeyFrameMatch& seen, const PoseEdge& step) const {
    const PoseEdge measured{step.from, step.to, seen.T_a_b, seen.information, false};
    const double depth_m = keys_[step.to].depth_m;
    return edge_sigmas(measured, Pose::Identity(), step.T_from_to) > kMistrackedSigmas &&
           shift_m(seen.T_a_b, step.T_from_to, depth_m) > kMistrackedDepths * depth_m;
  }

  /// The information of a tracked step. It is less along motions that the scene constrains little, by `seen`.
  [[nodiscard]] static Matrix6d step_information(const Pose& step, const std::optional<KeyFrameMatch>& seen) {
    const double metres = step.translation().norm();
    const double radians = angle_of(step);
    const double sigma_m = kStep_m + kStepPerMetre * metres;
    const double sigma_rad = kStep_rad + kStepRadPerRad * radians + kStepRadPerMetre * metres;
    Matrix6d covariance = Matrix6d::Zero();
    covariance.topLeftCorner<3, 3>().diagonal().setConstant(sigma_m * sigma_m);
    covariance.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_rad * sigma_rad);
    if (seen) {
      Matrix6d held = seen->information;
      held.diagonal().array() += kLeastHeld;
      covariance += kModelShare * held.inverse();
    }
    return covariance.inverse();
  }

  /// Some key frames before and after count as well, because tracking goes wrong, and recovers, by degrees.
  [[nodiscard]] std::vector<FrameRange> mistracked() const {
    std::vector<FrameRange> ranges;
    for (std::size_t step = 0; step < is_mistracked_.size(); ++step) {
      if (!is_mistracked_[step]) continue;
      const FrameRange range{keys_[step > kMistrackedBefore ? step - kMistrackedBefore : 0].frame,
                             keys_[std::min(step + kMistrackedAfter, keys_.size() - 1)].frame};
      if (!ranges.empty() && range.first <= ranges.back().last) {
        ranges.back().last = range.last;
      } else {
        ranges.push_back(range);
      }
    }
    return ranges;
  }

  /// The walk as the steps have it: what comes after a gap is put where the frames beside it say.
  void follow_steps() {
    for (const PoseEdge& step : steps_) poses_[step.to] = poses_[step.from] * step.T_from_to;
    stepped_ = poses_;
  }

  void find_candidates() {
    found_ = find_for_each<Candidate>(kFewestSteps, keys_.size(), [this](std::size_t b) {
      std::vector<Candidate> found;
      for (const std::size_t a : likely_partners(b)) {
        if (auto candidate = try_pair(a, b)) found.push_back(*std::move(candidate));
      }
      return found;
    });
  }

  [[nodiscard]] bool is_long_walk(std::size_t a, std::size_t b) const {
    const PathLength &from = keys_[a].path, &to = keys_[b].path;
    return to.walked_m - from.walked_m >= kFewestDepths * keys_[b].depth_m ||
           to.turned_rad - from.turned_rad >= kLeastTurn_rad || to.gaps > from.gaps;
  }

  /// Key frames before b that show the same place by where they are, or by their looks.
  [[nodiscard]] std::vector<std::size_t> likely_partners(std::size_t b) const {
    std::vector<std::pair<double, std::size_t>> by_place, by_looks;
    for (std::size_t a = 0; a + kFewestSteps <= b; ++a) {
      if (!is_long_walk(a, b)) break;
      const double overlap = expected_overlap(keys_[a], keys_[b], now(a, b));
      if (overlap >= kLeastExpectedOverlap) by_place.emplace_back(-overlap, a);
      const double difference = dissimilarity(keys_[a].code, keys_[b].code);
      if (overlap < kLeastExpectedOverlap && difference <= kMostDissimilar) by_looks.emplace_back(difference, a);
    }
    std::vector<std::size_t> partners;
    for (auto* likely : {&by_place, &by_looks}) {
      std::sort(likely->begin(), likely->end());
      likely->resize(std::min(likely->size(), likely == &by_place ? kMostByPlace : kMostByLooks));
      for (const auto& [order, a] : *likely) partners.push_back(a);
    }
    return partners;
  }

  [[nodiscard]] std::optional<Candidate> try_pair(std::size_t a, std::size_t b) const {
    std::vector<Pose> guesses{now(a, b)};
    const auto by_looks = match_features(keys_[a].features, keys_[b].features, keys_[b].seen.levels.front().intrinsics);
    if (by_looks) guesses.push_back(*by_looks);
    auto match = match_key_frames(keys_[a], keys_[b], guesses, registration_);
    if (!match) return std::nullopt;
    Candidate candidate{a, b, *std::move(match)};
    if (!could_drift(a, b, candidate.match.T_a_b)) candidate.refused = "farther than the walk can have drifted";
    return candidate;
  }

  [[nodiscard]] bool could_drift(std::size_t a, std::size_t b, const Pose& T_a_b) const {
    const PathLength &from = keys_[a].path, &to = keys_[b].path;
    const double metres = to.walked_m - from.walked_m;
    const double radians = to.turned_rad - from.turned_rad;
    const double gaps = to.gaps - from.gaps;
    const Pose apart = stepped(a, b).inverse() * T_a_b;
    return apart.translation().norm() <= kDrift_m + kDriftPerMetre * metres + kDriftOfGap_m * gaps &&
           angle_of(apart) <=
               kDrift_rad + kDriftRadPerMetre * metres + kDriftRadPerRad * radians + kDriftOfGap_rad * gaps;
  }

  void refuse_lonely() {
    std::vector<bool> is_lonely(found_.size(), false);
    for (std::size_t i = 0; i < found_.size(); ++i) {
      is_lonely[i] = std::none_of(found_.begin(), found_.end(), [&](const Candidate& other) {
        return &other != &found_[i] && other.refused.empty() && agree(found_[i], other);
      });
    }
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i].refused.empty() && is_lonely[i]) found_[i].refused = "no other loop agrees with it";
    }
  }

  /// a1 -> b1 -> b2 -> a2 -> a1 closes.
  [[nodiscard]] bool agree(const Candidate& one, const Candidate& two) const {
    const auto apart = [](std::size_t i, std::size_t k) { return i > k ? i - k : k - i; };
    if (apart(one.a, two.a) > kNearLoop || apart(one.b, two.b) > kNearLoop) return false;
    const Pose along_b = stepped(one.b, two.b);
    const Pose along_a = stepped(two.a, one.a);
    const Pose cycle = one.match.T_a_b * along_b * two.match.T_a_b.inverse() * along_a;
    const double metres = along_a.translation().norm() + along_b.translation().norm();
    return cycle.translation().norm() <= kCycle_m + kCyclePerMetre * metres && angle_of(cycle) <= kCycle_rad;
  }

  [[nodiscard]] bool has_believed() const {
    return std::any_of(found_.begin(), found_.end(), [](const Candidate& c) { return c.refused.empty(); });
  }

  [[nodiscard]] double shift_of(const Candidate& loop) const {
    return shift_m(stepped(loop.a, loop.b), loop.match.T_a_b, keys_[loop.b].depth_m);
  }

  /// Of what a key frame sees.
  [[nodiscard]] double largest_shift_m() const {
    double largest_m = 0;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      largest_m = std::max(largest_m, shift_m(keys_[i].T_world_camera, poses_[i], keys_[i].depth_m));
    }
    return largest_m;
  }

  /// False, and nothing has changed, when the walk does not bear it.
  bool distribute() {
    std::vector<PoseEdge> edges = steps_;
    edges.insert(edges.end(), neighbours_.begin(), neighbours_.end());
    const std::size_t first_loop = edges.size();
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const Candidate& loop = found_[i];
      if (!loop.refused.empty()) continue;
      edges.push_back({loop.a, loop.b, loop.match.T_a_b, loop.match.information, true});
      which.push_back(i);
    }
    std::vector<Pose> poses = poses_;
    const PoseGraphResult result = optimise_poses(poses, edges);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (!steps_[i].may_be_wrong && result.sigmas[i] > kMostStretched) {
        for (const std::size_t k : which) found_[k].refused = "the walk would have to be bent too much";
        return false;
      }
    }
    for (std::size_t k = 0; k < which.size(); ++k) {
      if (result.weights[first_loop + k] < kLeastWeight) found_[which[k]].refused = "the other loops contradict it";
    }
    poses_ = std::move(poses);
    return true;
  }

  /// A frame between two key frames keeps its place to both, more so to the nearer.
  void correct_walk(LoopClosure& closure) const {
    std::size_t next = 0;  // key frame at or after the frame
    for (std::size_t i = 0; i < walk_.size(); ++i) {
      while (next < keys_.size() && keys_[next].frame < i) ++next;
      const auto from = [&](std::size_t key) { return poses_[key] * keys_[key].T_world_camera.inverse() * walk_[i]; };
      Pose& pose = closure.T_world_cameras[i];
      if (next == 0) {
        pose = from(0);
      } else if (next == keys_.size()) {
        pose = from(next - 1);
      } else {
        const auto begin = static_cast<double>(keys_[next - 1].frame);
        const auto end = static_cast<double>(keys_[next].frame);
        pose = interpolate(from(next - 1), from(next), (static_cast<double>(i) - begin) / (end - begin));
      }
    }
  }

  void describe(LoopClosure& closure) const {
    for (const Candidate& found : found_) {
      Loop loop{keys_[found.a].frame, keys_[found.b].frame};
      loop.shift_m = shift_of(found);
      loop.overlap = found.match.overlap;
      loop.inlier_share = found.match.inlier_share;
      loop.refused = found.refused;
      if (loop.refused.empty()) closure.drift_m = std::max(closure.drift_m, loop.shift_m);
      closure.loops.push_back(std::move(loop));
    }
  }

  const std::vector<KeyFrame>& keys_;
  const std::vector<Pose>& walk_;
  IcpConfig registration_;
  std::vector<Pose> poses_;    ///< of the key frames, as corrected so far
  std::vector<Pose> stepped_;  ///< as the steps have them
  std::vector<PoseEdge> steps_;
  std::vector<PoseEdge> neighbours_;
  std::vector<bool> is_mistracked_;  ///< of each step
  std::vector<Candidate> found_;
};

}  // namespace

LoopClosure close_loops(const KeyFrames& frames, const NoiseModel& noise, double tolerance_m, bool colour_is_timely) {
  IcpConfig registration{noise};
  registration.colour_is_timely = colour_is_timely;
  return Closer(frames, registration).close(tolerance_m);
}

}  // namespace scanknit
