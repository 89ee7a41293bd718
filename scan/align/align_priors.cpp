#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "acquire/replay/text_numbers.h"
#include "core/files/read_file.h"
#include "scan/align/align_inputs.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kQuaternionTolerance = 0.01;
constexpr std::size_t kFewestMarkers = 3;

Error broken(const fs::path& path, const TextLine& line, const std::string& what) {
  return {ErrorCode::kInput, fmt::format("line {}: {}", line.number, what), path.string()};
}

/// The scan with this number, from 1, or with this file name.
std::optional<std::size_t> scan_named(std::string_view word, const AlignInputs& inputs) {
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    if (inputs.inputs[i].name == word || inputs.inputs[i].path.string() == word) return i;
  }
  const auto number = parse_numbers(word);
  if (!number || number->size() != 1) return std::nullopt;
  const double value = (*number)[0];
  if (!(value >= 1) || value > static_cast<double>(inputs.inputs.size()) || value != std::floor(value))
    return std::nullopt;
  return static_cast<std::size_t>(value) - 1;
}

/// The numbers after the first `words` words.
std::optional<std::vector<double>> numbers_after(const TextLine& line, std::size_t words) {
  std::string text;
  for (std::size_t i = words; i < line.words.size(); ++i) text += std::string(line.words[i]) + " ";
  auto numbers = parse_numbers(text);
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (!numbers || !std::all_of(numbers->begin(), numbers->end(), is_finite)) return std::nullopt;
  return numbers;
}

Result<Pose> pose_of(const std::vector<double>& v) {
  if (v.size() == 16) return pose_from_numbers(v);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1) <= kQuaternionTolerance)) {
    return Error{ErrorCode::kInput, "the quaternion's length is not 1"};
  }
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

using Markers = std::map<std::string, Eigen::Vector3d>;

/// The motion between two scans, from their common markers.
struct MarkerMotion {
  std::size_t common = 0;
  bool is_in_line = false;
  Pose T_from_to = Pose::Identity();
  double residual_m = 0;  ///< root mean square of the distances between markers after the motion
};

/// The rigid motion that fits the markers best (Umeyama 1991).
MarkerMotion motion_by(const Markers& from, const Markers& to) {
  Eigen::Matrix3Xd in_from(3, 0);
  Eigen::Matrix3Xd in_to(3, 0);
  for (const auto& [name, p_from] : from) {
    const auto p_to = to.find(name);
    if (p_to == to.end()) continue;
    in_from.conservativeResize(3, in_from.cols() + 1);
    in_to.conservativeResize(3, in_to.cols() + 1);
    in_from.rightCols<1>() = p_from;
    in_to.rightCols<1>() = p_to->second;
  }
  MarkerMotion motion;
  motion.common = static_cast<std::size_t>(in_from.cols());
  if (motion.common < kFewestMarkers) return motion;
  const auto is_in_line = [](const Eigen::Matrix3Xd& points) {
    const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
    const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::Matrix3Xd>(centred).singularValues();
    return !(spread[1] > 0.02 * spread[0]);
  };
  motion.is_in_line = is_in_line(in_from) || is_in_line(in_to);
  if (motion.is_in_line) return motion;
  motion.T_from_to = Pose(Eigen::umeyama(in_to, in_from, false));
  const Eigen::Matrix3Xd turned = motion.T_from_to.linear() * in_to;
  const Eigen::Vector3d moved = motion.T_from_to.translation();
  const Eigen::Matrix3Xd off = (turned.colwise() + moved) - in_from;
  motion.residual_m = std::sqrt(off.squaredNorm() / static_cast<double>(motion.common));
  return motion;
}

/// Why the markers of a pair are useless; empty when they are useful.
std::string fault_of(const MarkerMotion& motion, double most_residual_m) {
  if (motion.common < kFewestMarkers) {
    return fmt::format("the scans have {} markers in common, and at least {} are needed", motion.common,
                       kFewestMarkers);
  }
  if (motion.is_in_line) return "they lie on a line, so that any turn about that line fits";
  if (motion.residual_m > most_residual_m) {
    return fmt::format(
        "they do not fit each other: {:.1f} mm remain after the best motion; are two swapped, or the units "
        "different?",
        motion.residual_m * 1000);
  }
  return "";
}

class PriorLoader {
 public:
  PriorLoader(const AlignInputs& inputs, const Limits& limits) : inputs_(inputs), limits_(limits) {}

  /// To be called once.
  [[nodiscard]] Result<LoadedPriors> load(const KnownPlaces& known) {
    AlignPriors& priors = loaded_.priors;
    priors.may_fix_motion.assign(inputs_.inputs.size(), false);
    for (const AlignInput& input : inputs_.inputs) priors.T_world_scan.push_back(input.T_world_scan);
    const bool is_given = std::all_of(priors.T_world_scan.begin(), priors.T_world_scan.end(),
                                      [](const auto& pose) { return pose.has_value(); });
    priors.are_final = is_given && !known.wants_refinement && !known.initial && !known.markers;
    if (known.initial) {
      if (auto read = read_initial(*known.initial); !read) return read.error();
    }
    if (known.markers) {
      const auto markers = read_markers(*known.markers);
      if (!markers) return markers.error();
      add_marker_motions(*markers);
    }
    return std::move(loaded_);
  }

 private:
  [[nodiscard]] Result<void> read_initial(const fs::path& path) {
    const auto text = read_text_file(path, limits_.max_text_bytes);
    if (!text) return text.error();
    for (const TextLine& line : text_lines(*text)) {
      const auto scan = scan_named(line.words[0], inputs_);
      if (!scan)
        return broken(path, line,
                      fmt::format("there is no scan '{}'; expected a number from 1 to {}, or the name of a scan's file",
                                  line.words[0], inputs_.inputs.size()));
      const auto numbers = numbers_after(line, 1);
      if (!numbers || (numbers->size() != 7 && numbers->size() != 16)) {
        return broken(path, line, "expected SCAN tx ty tz qx qy qz qw, or SCAN and a 4x4 matrix row by row");
      }
      const auto pose = pose_of(*numbers);
      if (!pose) return broken(path, line, pose.error().message);
      if (loaded_.priors.may_fix_motion[*scan]) {
        loaded_.warnings.push_back(fmt::format("{}:{}: scan {} ({}) has a pose already; the last one counts",
                                               path.string(), line.number, *scan + 1, inputs_.inputs[*scan].name));
      }
      loaded_.priors.may_fix_motion[*scan] = true;
      loaded_.priors.T_world_scan[*scan] = *pose;
    }
    const auto known = std::count_if(loaded_.priors.T_world_scan.begin(), loaded_.priors.T_world_scan.end(),
                                     [](const auto& pose) { return pose.has_value(); });
    if (known < 2) {
      loaded_.warnings.push_back(
          fmt::format("{} has no effect: it has poses of {} scans, and the motion between scans "
                      "needs two",
                      path.string(), known));
    }
    return {};
  }

  [[nodiscard]] Result<std::vector<Markers>> read_markers(const fs::path& path) {
    const auto text = read_text_file(path, limits_.max_text_bytes);
    if (!text) return text.error();
    std::vector<Markers> markers(inputs_.inputs.size());
    for (const TextLine& line : text_lines(*text)) {
      const auto scan = scan_named(line.words[0], inputs_);
      if (!scan) return broken(path, line, fmt::format("there is no scan '{}'", line.words[0]));
      const auto numbers = line.words.size() == 5 ? numbers_after(line, 2) : std::nullopt;
      if (!numbers) return broken(path, line, "expected SCAN MARKER x y z, metres in the scan's own frame");
      const std::string name(line.words[1]);
      if (markers[*scan].contains(name)) {
        loaded_.warnings.push_back(fmt::format("{}:{}: marker {} of scan {} is there already; the last one counts",
                                               path.string(), line.number, name, *scan + 1));
      }
      markers[*scan][name] = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    }
    return markers;
  }

  void add_marker_motions(const std::vector<Markers>& markers) {
    const double most_residual_m = choose_scale(inputs_.models).coarse_m / 2;
    bool has_common = false;
    for (std::size_t from = 0; from < markers.size(); ++from) {
      for (std::size_t to = from + 1; to < markers.size(); ++to) {
        const MarkerMotion motion = motion_by(markers[from], markers[to]);
        has_common = has_common || motion.common > 0;
        if (motion.common == 0) continue;
        const std::string fault = fault_of(motion, most_residual_m);
        if (fault.empty()) {
          loaded_.priors.T_from_to[{from, to}] = motion.T_from_to;
        } else {
          loaded_.warnings.push_back(
              fmt::format("the markers of scans {} and {} are left out: {}", from + 1, to + 1, fault));
        }
      }
    }
    if (!has_common) {
      loaded_.warnings.push_back(
          "the markers have no effect: no marker has the same name in two scans; expected lines of SCAN MARKER "
          "x y z");
    }
  }

  const AlignInputs& inputs_;
  const Limits& limits_;
  LoadedPriors loaded_;
};

}  // namespace

Result<LoadedPriors> load_align_priors(const KnownPlaces& known, const AlignInputs& inputs, const Limits& limits) {
  return PriorLoader(inputs, limits).load(known);
}

Eigen::Vector3d offset_from_origin(const AlignPriors& priors) {
  constexpr double kFar_m = 1000;  // 32-bit floats have steps of a 16th of a millimetre there
  constexpr double kStep_m = 100;
  const auto known = std::find_if(priors.T_world_scan.begin(), priors.T_world_scan.end(),
                                  [](const auto& pose) { return pose.has_value(); });
  if (known == priors.T_world_scan.end() || (*known)->translation().norm() < kFar_m) return Eigen::Vector3d::Zero();
  return (((*known)->translation() / kStep_m).array().round() * kStep_m).matrix();
}

}  // namespace scanknit
