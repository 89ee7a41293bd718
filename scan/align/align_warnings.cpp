#include "scan/align/align_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace scanknit {
namespace {

constexpr double kLarge_m = 100;        // more is seldom scanned without a unit in the file
constexpr double kUnitRatio = 200;      // of sizes: scans of one object do not differ by so much
constexpr double kLeastOverlap = 0.12;  // below it, a pair is judged by its contradictions, not by its fit
constexpr double kMostAgainst = 0.03;   // of all points: more than noise and outlines cause
constexpr double kFarSpacings = 4;      // coarse spacings, which are a fortieth of the size each

double width_m(const ScanModel& model) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : model.all.points_m) box.extend(p);
  return box.isEmpty() ? 0 : double{box.sizes().maxCoeff()};
}

Eigen::Vector3d middle_of(const ScanModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : model.all.points_m) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, model.all.size()));
}

bool counts(const AlignedPair& pair) {
  return pair.judgement.verdict != PairVerdict::kUnacceptable;
}

std::string names_of(const AlignInputs& inputs, std::size_t from, std::size_t to) {
  return fmt::format("{} ({}) and {} ({})", from + 1, inputs.inputs[from].name, to + 1, inputs.inputs[to].name);
}

/// How far the scan moves from one pose to the other: the shift of its middle plus its rotation times its half width.
double distance_m(const Pose& x, const Pose& y, const ScanModel& model) {
  const Pose between = x.inverse() * y;
  const Eigen::Vector3d middle = middle_of(model);
  return (between * middle - middle).norm() + Eigen::AngleAxisd(between.linear()).angle() * width_m(model) / 2;
}

std::optional<Pose> by_poses(const AlignPriors& priors, std::size_t from, std::size_t to) {
  const auto& T_world_from = priors.T_world_scan[from];
  const auto& T_world_to = priors.T_world_scan[to];
  if (!T_world_from || !T_world_to) return std::nullopt;
  return Pose(T_world_from->inverse() * *T_world_to);
}

std::optional<std::string> misfit(const AlignInputs& inputs, const AlignedPair& pair) {
  if (counts(pair)) return std::nullopt;
  const std::string names = names_of(inputs, pair.from, pair.to);
  if (pair.measure.overlap >= kLeastOverlap) {
    return fmt::format("the given poses of {} do not fit: {}; refining corrects poses", names, pair.judgement.reason);
  }
  if (pair.measure.against <= kMostAgainst) return std::nullopt;
  return fmt::format(
      "the given poses of {} contradict what was seen: {:.0f} % of one lies where the other scanner looked through, or "
      "saw nothing; refining corrects poses",
      names, pair.measure.against * 100);
}

}  // namespace

std::vector<std::string> unit_warnings(const AlignInputs& inputs) {
  std::vector<std::string> warnings;
  std::size_t least = 0, most = 0;
  for (std::size_t i = 0; i < inputs.models.size(); ++i) {
    const double width = width_m(inputs.models[i]);
    if (width < width_m(inputs.models[least])) least = i;
    if (width > width_m(inputs.models[most])) most = i;
    if (width < kLarge_m || inputs.inputs[i].kind == AlignKind::kRecording) continue;
    warnings.push_back(
        fmt::format("{} is {:.0f} m wide: its numbers are taken as metres; if they are millimetres, scale "
                    "them by 0.001",
                    inputs.inputs[i].name, width));
  }
  const double smallest = inputs.models.empty() ? 0 : width_m(inputs.models[least]);
  const double ratio = smallest > 0 ? width_m(inputs.models[most]) / smallest : 0;
  if (ratio > kUnitRatio) {
    warnings.push_back(fmt::format("{} is {:.0f} times as wide as {}: is one of them in millimetres?",
                                   inputs.inputs[most].name, ratio, inputs.inputs[least].name));
  }
  return warnings;
}

std::vector<std::string> given_pose_warnings(const AlignInputs& inputs, const Alignment& alignment) {
  std::vector<std::string> warnings;
  std::vector<bool> is_borne_out(inputs.inputs.size(), false);
  for (const AlignedPair& pair : alignment.pairs) {
    if (const auto warning = misfit(inputs, pair)) warnings.push_back(*warning);
    if (counts(pair)) is_borne_out[pair.from] = is_borne_out[pair.to] = true;
  }
  for (std::size_t i = 0; i < is_borne_out.size() && is_borne_out.size() > 1; ++i) {
    if (is_borne_out[i]) continue;
    warnings.push_back(
        fmt::format("no other scan confirms the given pose of {} ({}): none fits it there; look at the "
                    "pictures of its pairs, or let refining look for its place",
                    i + 1, inputs.inputs[i].name));
  }
  return warnings;
}

std::vector<std::string> prior_warnings(const AlignInputs& inputs, const AlignPriors& priors,
                                        const Alignment& alignment) {
  std::vector<std::string> warnings;
  const double far_m = kFarSpacings * alignment.scale.coarse_m;
  for (const AlignedPair& pair : alignment.pairs) {
    const auto poses = by_poses(priors, pair.from, pair.to);
    const auto markers = priors.T_from_to.find({pair.from, pair.to});
    const bool has_markers = markers != priors.T_from_to.end();
    if (!poses && !has_markers) continue;
    const ScanModel& model = inputs.models[pair.to];
    const std::string names = names_of(inputs, pair.from, pair.to);
    if (poses && has_markers && distance_m(*poses, markers->second, model) > far_m) {
      warnings.push_back(fmt::format("poses and markers of {} contradict each other by {:.0f} mm; the markers are used",
                                     names, distance_m(*poses, markers->second, model) * 1000));
    }
    if (!counts(pair)) continue;
    const Pose found = alignment.T_world_scan[pair.from].inverse() * alignment.T_world_scan[pair.to];
    const double off_m = distance_m(has_markers ? markers->second : *poses, found, model);
    if (off_m <= far_m) continue;
    warnings.push_back(
        fmt::format("the {} of {} differ by {:.0f} mm from the pose at which the scans fit; that pose is used",
                    has_markers ? "markers" : "poses", names, off_m * 1000));
  }
  return warnings;
}

}  // namespace scanknit
