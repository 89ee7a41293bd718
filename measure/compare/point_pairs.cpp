#include "measure/compare/point_pairs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <charconv>
#include <cmath>
#include <optional>

namespace scanknit {
namespace {

Error pairs_error(std::string message) {
  return Error{ErrorCode::kInput, std::move(message)};
}

/// The numbers of a text, with spaces, commas or line ends between; nothing if there is anything else.
std::optional<std::vector<double>> numbers_of(std::string_view text) {
  constexpr std::string_view kBetween = " \t\r\n,;";
  std::vector<double> numbers;
  for (std::size_t at = text.find_first_not_of(kBetween); at != std::string_view::npos;
       at = text.find_first_not_of(kBetween, at)) {
    const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
    double number = 0;
    const auto [last, error] = std::from_chars(text.data() + at, text.data() + end, number);
    if (error != std::errc{} || last != text.data() + end || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    at = end;
  }
  return numbers;
}

}  // namespace

Result<std::vector<PointPair>> parse_point_pairs(std::string_view text) {
  std::vector<PointPair> pairs;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    content = content.substr(0, content.find('#'));
    const auto numbers = numbers_of(content);
    if (numbers && numbers->empty()) continue;
    if (!numbers || numbers->size() != 6) {
      return pairs_error(
          fmt::format("line {}: expected six numbers, x y z on the mesh and x y z on the reference", line));
    }
    const auto& n = *numbers;
    pairs.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}});
  }
  return pairs;
}

Result<Pose> fit_pairs(const std::vector<PointPair>& pairs) {
  if (pairs.size() < 3) return pairs_error(fmt::format("{} pairs of points, expected at least 3", pairs.size()));
  Eigen::Matrix3Xd on_mesh(3, pairs.size()), on_reference(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    on_mesh.col(static_cast<Eigen::Index>(i)) = pairs[i].on_mesh;
    on_reference.col(static_cast<Eigen::Index>(i)) = pairs[i].on_reference;
  }
  constexpr double kLeastSpread = 1e-3;  // across the line that fits best, relative to along it
  for (const auto& points : {on_mesh, on_reference}) {
    const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
    const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
    if (!(spread[1] > kLeastSpread * spread[0])) {
      return pairs_error("the points lie on one line, expected three that make a triangle");
    }
  }
  Pose T_reference_mesh = Pose::Identity();
  T_reference_mesh.matrix() = Eigen::umeyama(on_mesh, on_reference, false);
  if (!T_reference_mesh.matrix().allFinite()) return pairs_error("the points' numbers are too large");
  return T_reference_mesh;
}

Result<Pose> parse_rigid_matrix(std::string_view text, double metres) {
  const auto numbers = numbers_of(text);
  if (!numbers || numbers->size() != 16) return pairs_error("expected the 16 numbers of a matrix, row by row");
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
  constexpr double kMostOff = 1e-3;  // a matrix of a few digits is still taken
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  const bool is_turn = (turn * turn.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kMostOff &&
                       turn.determinant() > 0;
  if (!is_turn || !matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kMostOff)) {
    return pairs_error("the matrix is no rotation and translation, expected one without scale or mirroring");
  }
  Pose T_reference_mesh = Pose::Identity();
  T_reference_mesh.linear() = Eigen::Quaterniond(turn).normalized().toRotationMatrix();
  T_reference_mesh.translation() = metres * matrix.topRightCorner<3, 1>();
  return T_reference_mesh;
}

}  // namespace scanknit
