#include "fusion/align/align_scans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/check.h"
#include "fusion/align/coarse_search.h"
#include "fusion/loops/pose_graph.h"

namespace scanknit {
namespace {

constexpr double kFeatureRadius = 5;  // coarse spacings
constexpr int kCoarseRounds = 20;
constexpr int kFineRounds = 40;
constexpr std::size_t kRefined = 6;  // candidates of the coarse search that are registered finely
constexpr double kAmbiguous = 0.9;   // of the best score: another pose that fits as well
constexpr double kSameTurn = 0.15;   // rad; and
constexpr double kSamePlace = 3;     // coarse spacings: two poses that are one
constexpr double kConsistent = 2.0;  // fine spacings: as far may measured pairs be from each other
constexpr double kEdgePairs = 4;     // pairs of points count as so many independent measurements

struct FoundPose {
  FineMatch match;
  PairMeasure measure;
  double score = -HUGE_VAL;
};

Eigen::Vector3d middle_of(const ScanModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : model.all.points_m) sum += p.cast<double>();
  return model.all.size() == 0 ? sum : Eigen::Vector3d(sum / static_cast<double>(model.all.size()));
}

double radius_of(const ScanModel& model, const Eigen::Vector3d& middle) {
  double squares = 0;
  for (const Eigen::Vector3f& p : model.all.points_m) squares += (p.cast<double>() - middle).squaredNorm();
  return model.all.size() == 0 ? 0 : std::sqrt(squares / static_cast<double>(model.all.size()));
}

class ScanAligner {
 public:
  ScanAligner(const std::vector<ScanModel>& models, const AlignPriors& priors, const AlignProgress& progress)
      : models_(models), priors_(priors), progress_(progress) {
    result_.scale = choose_scale(models);
    result_.T_world_scan.assign(models.size(), Pose::Identity());
    result_.is_placed.assign(models.size(), false);
  }

  [[nodiscard]] Result<Alignment> align() {
    if (models_.empty() || !(result_.scale.fine_m > 0)) return std::move(result_);
    prepare();
    for (std::size_t from = 0; from < models_.size(); ++from) {
      for (std::size_t to = from + 1; to < models_.size(); ++to) {
        auto pair = priors_.are_final ? measure_given(from, to) : find_pair(from, to);
        if (!pair) return pair.error();
        result_.pairs.push_back(*std::move(pair));
        const std::size_t total = models_.size() * (models_.size() - 1) / 2;
        if (progress_ && !progress_(result_.pairs.size(), total)) return std::move(result_);
      }
    }
    if (priors_.are_final) {
      for (std::size_t i = 0; i < models_.size(); ++i) {
        result_.T_world_scan[i] = *priors_.T_world_scan[i];
        result_.is_placed[i] = true;
      }
      return std::move(result_);
    }
    place();
    look_again();
    place();
    finish();
    return std::move(result_);
  }

 private:
  void prepare() {
    const AlignScale& scale = result_.scale;
    for (const ScanModel& model : models_) {
      prepared_.push_back({&model, ScanLevel(thin_out(model.all, scale.coarse_m), scale.coarse_m),
                           ScanLevel(thin_out(model.all, scale.fine_m), scale.fine_m)});
      middles_.push_back(middle_of(model));
      radii_.push_back(radius_of(model, middles_.back()));
    }
    features_.resize(models_.size());
  }

  [[nodiscard]] Result<void> describe(std::size_t scan) {
    if (!features_[scan].empty()) return {};
    auto features = surface_features(prepared_[scan].coarse.points, kFeatureRadius * result_.scale.coarse_m);
    if (!features) return features.error();
    features_[scan] = *std::move(features);
    return {};
  }

  [[nodiscard]] std::optional<Pose> prior_of(std::size_t from, std::size_t to) const {
    if (const auto found = priors_.T_from_to.find({from, to}); found != priors_.T_from_to.end()) return found->second;
    if (priors_.T_world_scan.empty()) return std::nullopt;
    const auto& T_world_from = priors_.T_world_scan[from];
    const auto& T_world_to = priors_.T_world_scan[to];
    if (!T_world_from || !T_world_to) return std::nullopt;
    return Pose(T_world_from->inverse() * *T_world_to);
  }

  [[nodiscard]] double distance(const Pose& x, const Pose& y, std::size_t scan) const {
    const Pose between = x.inverse() * y;
    const Eigen::Vector3d& middle = middles_[scan];
    return (between * middle - middle).norm() + Eigen::AngleAxisd(between.linear()).angle() * radii_[scan];
  }

  [[nodiscard]] FoundPose measured(std::size_t from, std::size_t to, const FineMatch& match, CheckLevel level) const {
    const double spacing = level == CheckLevel::kFine ? result_.scale.fine_m : result_.scale.coarse_m;
    FoundPose found{match, measure_pair(prepared_[from], prepared_[to], match.T_a_b, level), 0};
    found.measure.least_strength = match.least_strength;
    found.measure.is_fixed_by_prior = match.has_fixed_motion;
    found.score = match.pairs == 0 ? -HUGE_VAL : score_of(found.measure, spacing);
    return found;
  }

  [[nodiscard]] FoundPose refined(std::size_t from, std::size_t to, const Pose& start, bool is_rough) const {
    const PreparedScan &a = prepared_[from], &b = prepared_[to];
    const Pose near = is_rough ? match_finely(a.coarse, b.coarse, start, kCoarseRounds).T_a_b : start;
    return measured(from, to, match_finely(a.fine, b.fine, near, kFineRounds), CheckLevel::kFine);
  }

  /// Moved only as far as the shape says where to.
  [[nodiscard]] FoundPose held_by(const Pose& prior, std::size_t from, std::size_t to) const {
    const PreparedScan &a = prepared_[from], &b = prepared_[to];
    const Pose near = match_finely(a.coarse, b.coarse, prior, kCoarseRounds, kLeastStrength).T_a_b;
    return measured(from, to, match_finely(a.fine, b.fine, near, kFineRounds, kLeastStrength), CheckLevel::kFine);
  }

  [[nodiscard]] bool may_fix_motion(std::size_t from, std::size_t to) const {
    if (priors_.T_from_to.contains({from, to})) return true;
    return !priors_.may_fix_motion.empty() && priors_.may_fix_motion[from] && priors_.may_fix_motion[to];
  }

  [[nodiscard]] AlignedPair pair_of(std::size_t from, std::size_t to, const FoundPose& found, PairStart start) const {
    AlignedPair pair;
    pair.from = from;
    pair.to = to;
    pair.T_from_to = found.match.T_a_b;
    pair.measure = found.measure;
    pair.judgement = judge_pair(found.measure, result_.scale.fine_m);
    pair.start = start;
    return pair;
  }

  [[nodiscard]] Result<AlignedPair> measure_given(std::size_t from, std::size_t to) {
    FineMatch match = match_finely(prepared_[from].fine, prepared_[to].fine, *prior_of(from, to), 1);
    match.T_a_b = *prior_of(from, to);
    return pair_of(from, to, measured(from, to, match, CheckLevel::kFine), PairStart::kGiven);
  }

  [[nodiscard]] Result<AlignedPair> find_pair(std::size_t from, std::size_t to) {
    matches_[{from, to}] = {};
    if (const auto prior = prior_of(from, to)) {
      const FoundPose found = refined(from, to, *prior, true);
      const AlignedPair pair = pair_of(from, to, found, PairStart::kPrior);
      matches_[{from, to}] = found.match;
      if (counts(pair)) return pair;
      if (may_fix_motion(from, to)) {
        const FoundPose held = held_by(*prior, from, to);
        const AlignedPair held_pair = pair_of(from, to, held, PairStart::kPrior);
        matches_[{from, to}] = held.match;
        if (counts(held_pair)) return held_pair;
      }
    }
    return search_pair(from, to);
  }

  [[nodiscard]] Result<AlignedPair> search_pair(std::size_t from, std::size_t to) {
    for (const std::size_t scan : {from, to}) {
      if (auto described = describe(scan); !described) return described.error();
    }
    const PreparedScan &a = prepared_[from], &b = prepared_[to];
    std::vector<FoundPose> candidates;
    const std::uint64_t seed = from * models_.size() + to;
    for (const Pose& start : search_coarsely(a.coarse, features_[from], b.coarse, features_[to], seed)) {
      const FoundPose found =
          measured(from, to, match_finely(a.coarse, b.coarse, start, kCoarseRounds), CheckLevel::kCoarse);
      if (found.match.pairs > 0) add_distinct(candidates, found, to);
    }
    sort_by_score(candidates);
    candidates.resize(std::min(candidates.size(), kRefined));
    std::vector<FoundPose> fine;
    for (const FoundPose& candidate : candidates) {
      const FoundPose found = refined(from, to, candidate.match.T_a_b, false);
      if (found.match.pairs > 0) add_distinct(fine, found, to);
    }
    sort_by_score(fine);
    AlignedPair pair;
    pair.from = from;
    pair.to = to;
    pair.judgement = {PairVerdict::kUnacceptable, "nothing alike was found"};
    pair.start = PairStart::kSearch;
    if (fine.empty()) return pair;
    // What can be refuted is no rival to what cannot.
    const auto holds = [&](const FoundPose& found) { return counts(pair_of(from, to, found, PairStart::kSearch)); };
    std::stable_partition(fine.begin(), fine.end(), holds);
    pair = pair_of(from, to, fine.front(), PairStart::kSearch);
    matches_[{from, to}] = fine.front().match;
    const bool is_ambiguous =
        counts(pair) && fine.size() > 1 && holds(fine[1]) && fine[1].score > kAmbiguous * fine[0].score;
    if (is_ambiguous) {
      pair.judgement = {PairVerdict::kUnacceptable, "it fits as well in another place: give initial poses or markers"};
    }
    return pair;
  }

  static void sort_by_score(std::vector<FoundPose>& found) {
    std::stable_sort(found.begin(), found.end(),
                     [](const FoundPose& x, const FoundPose& y) { return x.score > y.score; });
  }

  /// Of two that have become one the better stays.
  void add_distinct(std::vector<FoundPose>& all, const FoundPose& found, std::size_t scan) const {
    for (FoundPose& other : all) {
      const Pose between = other.match.T_a_b.inverse() * found.match.T_a_b;
      const bool is_same = Eigen::AngleAxisd(between.linear()).angle() < kSameTurn &&
                           (between * middles_[scan] - middles_[scan]).norm() < kSamePlace * result_.scale.coarse_m;
      if (!is_same) continue;
      if (found.score > other.score) other = found;
      return;
    }
    all.push_back(found);
  }

  [[nodiscard]] static bool counts(const AlignedPair& pair) {
    return pair.judgement.verdict != PairVerdict::kUnacceptable;
  }

  /// Pairs that count, those that agree with most triangles first, then by overlap.
  [[nodiscard]] std::vector<std::size_t> by_trust() const {
    std::vector<std::size_t> order;
    std::vector<double> trust(result_.pairs.size(), 0);
    for (std::size_t i = 0; i < result_.pairs.size(); ++i) {
      if (!counts(result_.pairs[i])) continue;
      order.push_back(i);
      trust[i] = result_.pairs[i].measure.overlap + agreeing_triangles(result_.pairs[i]);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return trust[x] > trust[y]; });
    return order;
  }

  [[nodiscard]] std::optional<Pose> measured_motion(std::size_t from, std::size_t to) const {
    for (const AlignedPair& pair : result_.pairs) {
      if (!counts(pair)) continue;
      if (pair.from == from && pair.to == to) return pair.T_from_to;
      if (pair.from == to && pair.to == from) return pair.T_from_to.inverse();
    }
    return std::nullopt;
  }

  [[nodiscard]] double agreeing_triangles(const AlignedPair& pair) const {
    double agreement = 0;
    for (std::size_t third = 0; third < models_.size(); ++third) {
      if (third == pair.from || third == pair.to) continue;
      const auto out = measured_motion(pair.from, third);
      const auto back = measured_motion(third, pair.to);
      if (!out || !back) continue;
      const double off = distance(pair.T_from_to, *out * *back, pair.to);
      agreement += off < 2 * kConsistent * result_.scale.fine_m ? 1 : -1;
    }
    return agreement;
  }

  /// A tree of the most trusted pairs gives first poses; pairs that contradict it are registered anew from there, or
  /// refused; the graph of all that are left spreads what remains.
  void place() {
    std::vector<std::size_t> group(models_.size());
    std::iota(group.begin(), group.end(), std::size_t{0});
    std::vector<Pose>& T = result_.T_world_scan;
    T.assign(models_.size(), Pose::Identity());
    for (const std::size_t i : by_trust()) {
      const AlignedPair& pair = result_.pairs[i];
      if (group[pair.from] == group[pair.to]) continue;
      // The whole group of `to` moves.
      const Pose motion = T[pair.from] * pair.T_from_to * T[pair.to].inverse();
      const std::size_t moved = group[pair.to];
      for (std::size_t k = 0; k < models_.size(); ++k) {
        if (group[k] != moved) continue;
        T[k] = motion * T[k];
        group[k] = group[pair.from];
      }
    }
    for (AlignedPair& pair : result_.pairs) {
      if (counts(pair)) reconcile(pair);
    }
    optimise();
    for (std::size_t k = 0; k < models_.size(); ++k) result_.is_placed[k] = group[k] == group[0];
  }

  void reconcile(AlignedPair& pair) {
    const Pose by_others = result_.T_world_scan[pair.from].inverse() * result_.T_world_scan[pair.to];
    const double most = kConsistent * result_.scale.fine_m;
    if (distance(pair.T_from_to, by_others, pair.to) < most) return;
    const FoundPose found = refined(pair.from, pair.to, by_others, false);
    AlignedPair again = pair_of(pair.from, pair.to, found, PairStart::kOthers);
    if (counts(again) && distance(again.T_from_to, by_others, pair.to) < 2 * most) {
      matches_[{pair.from, pair.to}] = found.match;
      pair = again;
      return;
    }
    pair.judgement = {PairVerdict::kUnacceptable, "it contradicts the other pairs"};
  }

  void optimise() {
    std::vector<PoseEdge> edges;
    for (const AlignedPair& pair : result_.pairs) {
      if (!counts(pair)) continue;
      const FineMatch& match = matches_[{pair.from, pair.to}];
      const double sigma = std::max(match.residual_m, 0.05 * result_.scale.fine_m);
      PoseEdge edge{.from = pair.from, .to = pair.to, .T_from_to = pair.T_from_to};
      edge.information = match.shape * (kEdgePairs * pair.measure.overlap / (sigma * sigma));
      edge.may_be_wrong = true;
      edges.push_back(edge);
    }
    (void)optimise_poses(result_.T_world_scan, edges);
  }

  /// Pairs that were refused, but have a place by the others now.
  void look_again() {
    for (AlignedPair& pair : result_.pairs) {
      if (counts(pair) || !result_.is_placed[pair.from] || !result_.is_placed[pair.to]) continue;
      const Pose by_others = result_.T_world_scan[pair.from].inverse() * result_.T_world_scan[pair.to];
      const FoundPose found = refined(pair.from, pair.to, by_others, false);
      AlignedPair again = pair_of(pair.from, pair.to, found, PairStart::kOthers);
      const bool stays = distance(again.T_from_to, by_others, pair.to) < 2 * kConsistent * result_.scale.fine_m;
      if (counts(again) && stays) {
        matches_[{pair.from, pair.to}] = found.match;
        pair = again;
        continue;
      }
      FineMatch there = match_finely(prepared_[pair.from].fine, prepared_[pair.to].fine, by_others, 1);
      there.T_a_b = by_others;
      AlignedPair as_placed =
          pair_of(pair.from, pair.to, measured(pair.from, pair.to, there, CheckLevel::kFine), PairStart::kOthers);
      if (!counts(as_placed)) {
        pair = as_placed;
      } else {  // it fits where it is, but would slide
        as_placed.judgement = {PairVerdict::kUnacceptable,
                               "it fits where the others put it, but does not hold it there"};
        pair = as_placed;
      }
    }
  }

  /// Measures at the final poses, in the world of the first scan's prior.
  void finish() {
    const auto& known = priors_.T_world_scan;
    const Pose T_world_first = !known.empty() && known[0] ? *known[0] : Pose::Identity();
    const Pose motion = T_world_first * result_.T_world_scan[0].inverse();
    for (Pose& pose : result_.T_world_scan) {
      pose = motion * pose;
      pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    }
    for (AlignedPair& pair : result_.pairs) {
      if (!counts(pair)) continue;
      const Pose final = result_.T_world_scan[pair.from].inverse() * result_.T_world_scan[pair.to];
      pair.off_m = distance(pair.T_from_to, final, pair.to);
      const PairMeasure matched = pair.measure;
      pair.measure = measure_pair(prepared_[pair.from], prepared_[pair.to], final, CheckLevel::kFine);
      pair.measure.least_strength = matched.least_strength;
      pair.measure.is_fixed_by_prior = matched.is_fixed_by_prior;
      pair.judgement = judge_pair(pair.measure, result_.scale.fine_m);
    }
  }

  const std::vector<ScanModel>& models_;
  const AlignPriors& priors_;
  const AlignProgress& progress_;
  std::vector<PreparedScan> prepared_;
  std::vector<Eigen::Vector3d> middles_;
  std::vector<double> radii_;
  std::vector<std::vector<SurfaceFeature>> features_;
  std::map<std::pair<std::size_t, std::size_t>, FineMatch> matches_;
  Alignment result_;
};

}  // namespace

Result<Alignment> align_scans(const std::vector<ScanModel>& models, const AlignPriors& priors,
                              const AlignProgress& progress) {
  SCANKNIT_CHECK(priors.T_world_scan.empty() || priors.T_world_scan.size() == models.size());
  return ScanAligner(models, priors, progress).align();
}

}  // namespace scanknit
