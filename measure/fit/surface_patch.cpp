#include "measure/fit/surface_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace scanknit {
namespace {

using Eigen::Vector3d;
using CornerPoints = std::array<Vector3d, 3>;

/// Halves the triangle at its longest side until its pieces are small enough.
class PieceCutter {
 public:
  PieceCutter(const Vector3d& centre_m, double radius_m, std::vector<PatchPiece>& pieces)
      : centre_m_(centre_m), radius_m_(radius_m), pieces_(pieces) {}

  void cut(const CornerPoints& corners) { cut(corners, (corners[1] - corners[0]).cross(corners[2] - corners[0])); }

 private:
  static constexpr double kPiecesPerRadius = 8;

  void cut(const CornerPoints& corners, const Vector3d& doubled_area) {
    const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
    double reach = 0;  // of the triangle from its middle
    for (const Vector3d& corner : corners) reach = std::max(reach, (corner - middle).norm());
    const double away = (middle - centre_m_).norm();
    if (away - reach > radius_m_) return;
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (side(corners, k) > side(corners, longest)) longest = k;
    }
    if (side(corners, longest) <= radius_m_ / kPiecesPerRadius) {
      const double size = doubled_area.norm();
      if (away <= radius_m_ && size > 0) pieces_.push_back({middle, doubled_area / size, size / 2});
      return;
    }
    const Vector3d &a = corners[longest], &b = corners[(longest + 1) % 3], &c = corners[(longest + 2) % 3];
    const Vector3d half = (a + b) / 2;
    if (half == a || half == b) return;  // no number lies between
    cut({a, half, c}, doubled_area / 2);
    cut({half, b, c}, doubled_area / 2);
  }

  static double side(const CornerPoints& corners, std::size_t k) { return (corners[(k + 1) % 3] - corners[k]).norm(); }

  const Vector3d& centre_m_;
  double radius_m_;
  std::vector<PatchPiece>& pieces_;
};

}  // namespace

std::vector<PatchPiece> patch_round(const Mesh& mesh, const Vector3d& centre_m, double radius_m) {
  constexpr std::size_t kMostPieces = 20'000;
  std::vector<PatchPiece> pieces;
  PieceCutter cutter(centre_m, radius_m, pieces);
  for (const Triangle& t : mesh.triangles) {
    cutter.cut({mesh.positions_m[t[0]].cast<double>(), mesh.positions_m[t[1]].cast<double>(),
                mesh.positions_m[t[2]].cast<double>()});
  }
  const std::size_t every = pieces.size() / kMostPieces + 1;
  if (every == 1) return pieces;
  std::vector<PatchPiece> kept;
  for (std::size_t i = 0; i < pieces.size(); i += every) {
    kept.push_back(pieces[i]);
    kept.back().area_m2 *= static_cast<double>(every);
  }
  return kept;
}

}  // namespace scanknit
