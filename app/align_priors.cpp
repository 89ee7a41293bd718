#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "acquire/replay/text_numbers.h"
#include "app/align_inputs.h"
#include "core/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kQuaternionTolerance = 0.01;
constexpr std::size_t kFewestMarkers = 3;

Error broken(const fs::path& path, const TextLine& line, const std::string& what) {
  return {ErrorCode::kInput, fmt::format("line {}: {}", line.number, what), path.string()};
}

/// By number, from 1, or by the name of the file.
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

Result<void> read_initial(const fs::path& path, const AlignInputs& inputs, const Limits& limits, AlignPriors& priors) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  for (const TextLine& line : text_lines(*text)) {
    const auto scan = scan_named(line.words[0], inputs);
    if (!scan)
      return broken(path, line,
                    fmt::format("no scan is called '{}'; there are 1 to {}, or their files' names", line.words[0],
                                inputs.inputs.size()));
    const auto numbers = numbers_after(line, 1);
    if (!numbers || (numbers->size() != 7 && numbers->size() != 16)) {
      return broken(path, line, "expected SCAN tx ty tz qx qy qz qw, or SCAN and a 4x4 matrix row by row");
    }
    const auto pose = pose_of(*numbers);
    if (!pose) return broken(path, line, pose.error().message);
    priors.T_world_scan[*scan] = *pose;
  }
  return {};
}

using Markers = std::map<std::string, Eigen::Vector3d>;

Result<std::vector<Markers>> read_markers(const fs::path& path, const AlignInputs& inputs, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  std::vector<Markers> markers(inputs.inputs.size());
  for (const TextLine& line : text_lines(*text)) {
    const auto scan = scan_named(line.words[0], inputs);
    if (!scan) return broken(path, line, fmt::format("no scan is called '{}'", line.words[0]));
    const auto numbers = line.words.size() == 5 ? numbers_after(line, 2) : std::nullopt;
    if (!numbers) return broken(path, line, "expected SCAN MARKER x y z, metres in the scan's own frame");
    markers[*scan][std::string(line.words[1])] = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
  }
  return markers;
}

/// The rigid motion that brings markers together (Umeyama 1991); nothing for fewer than three, or three in a line.
std::optional<Pose> motion_by(const Markers& from, const Markers& to) {
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
  if (in_from.cols() < static_cast<Eigen::Index>(kFewestMarkers)) return std::nullopt;
  const Eigen::Matrix3Xd centred = in_to.colwise() - in_to.rowwise().mean();
  const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::Matrix3Xd>(centred).singularValues();
  if (!(spread[1] > 0.02 * spread[0])) return std::nullopt;
  return Pose(Eigen::umeyama(in_to, in_from, false));
}

}  // namespace

Result<AlignPriors> load_align_priors(const AlignArguments& arguments, const AlignInputs& inputs,
                                      const Limits& limits) {
  AlignPriors priors;
  for (const AlignInput& input : inputs.inputs) priors.T_world_scan.push_back(input.T_world_scan);
  const bool is_given = std::all_of(priors.T_world_scan.begin(), priors.T_world_scan.end(),
                                    [](const auto& pose) { return pose.has_value(); });
  priors.are_final = is_given && !arguments.wants_refinement && !arguments.initial && !arguments.markers;
  if (arguments.initial) {
    if (auto read = read_initial(*arguments.initial, inputs, limits, priors); !read) return read.error();
  }
  if (!arguments.markers) return priors;
  const auto markers = read_markers(*arguments.markers, inputs, limits);
  if (!markers) return markers.error();
  for (std::size_t from = 0; from < markers->size(); ++from) {
    for (std::size_t to = from + 1; to < markers->size(); ++to) {
      if (const auto motion = motion_by((*markers)[from], (*markers)[to])) priors.T_from_to[{from, to}] = *motion;
    }
  }
  return priors;
}

}  // namespace scanknit
