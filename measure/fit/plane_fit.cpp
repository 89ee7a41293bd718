#include "measure/fit/plane_fit.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "measure/fit/surface_patch.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr double kSameWay = 0.866;  // cosine of 30 degrees
constexpr std::size_t kFewestPieces = 8;

const PatchPiece& nearest_piece(const std::vector<PatchPiece>& pieces, const Vector3d& at_m) {
  return *std::min_element(pieces.begin(), pieces.end(), [&](const PatchPiece& a, const PatchPiece& b) {
    return (a.middle_m - at_m).squaredNorm() < (b.middle_m - at_m).squaredNorm();
  });
}

double area_of(const std::vector<PatchPiece>& pieces) {
  double area = 0;
  for (const PatchPiece& piece : pieces) area += piece.area_m2;
  return area;
}

/// The best plane of all pieces, facing as `like` does.
FittedPlane plane_through(const std::vector<PatchPiece>& pieces, const Vector3d& like) {
  FittedPlane plane;
  plane.area_m2 = area_of(pieces);
  for (const PatchPiece& piece : pieces) plane.middle_m += piece.middle_m * piece.area_m2 / plane.area_m2;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const PatchPiece& piece : pieces) {
    const Vector3d away = piece.middle_m - plane.middle_m;
    spread += piece.area_m2 * away * away.transpose();
  }
  plane.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  if (plane.normal.dot(like) < 0) plane.normal *= -1;
  plane.offset_m = plane.normal.dot(plane.middle_m);
  double squares = 0;
  for (const PatchPiece& piece : pieces) {
    const double off = plane.normal.dot(piece.middle_m) - plane.offset_m;
    squares += piece.area_m2 * off * off;
    plane.min_m = std::min(plane.min_m, off);
    plane.max_m = std::max(plane.max_m, off);
  }
  plane.rms_m = std::sqrt(squares / plane.area_m2);
  return plane;
}

}  // namespace

Result<FittedPlane> fit_plane(const Mesh& mesh, const Vector3d& at_m, double radius_m) {
  constexpr int kRounds = 5;
  constexpr double kMostSigmas = 3;
  const std::vector<PatchPiece> all = patch_round(mesh, at_m, radius_m);
  const auto too_little = [&] {
    return Error{
        ErrorCode::kTooLittle,
        fmt::format("there is too little surface within {:.4g} mm of the point for a plane; take a larger radius, "
                    "or a point on the surface",
                    radius_m * 1000)};
  };
  if (all.size() < kFewestPieces) return too_little();
  FittedPlane plane;
  plane.normal = nearest_piece(all, at_m).normal;
  for (int round = 0; round < kRounds; ++round) {
    const double most_off_m = round == 0 ? radius_m : std::max(kMostSigmas * plane.rms_m, 1e-6 * radius_m);
    std::vector<PatchPiece> own;
    for (const PatchPiece& piece : all) {
      const double off = round == 0 ? 0 : plane.normal.dot(piece.middle_m) - plane.offset_m;
      if (piece.normal.dot(plane.normal) >= kSameWay && std::abs(off) <= most_off_m) own.push_back(piece);
    }
    if (own.size() < kFewestPieces) return too_little();
    plane = plane_through(own, plane.normal);
  }
  plane.share = plane.area_m2 / area_of(all);
  return plane;
}

}  // namespace scanknit
