#include "measure/compare/signed_distance.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <limits>
#include <optional>

#include "core/check.h"

namespace scanknit {

SignedDistance::SignedDistance(const Mesh& mesh) : tree_(mesh), normals_(mesh), edges_(normals_.count_edges()) {
  is_inside_out_ = edges_.border == 0 && signed_volume_m3(mesh) < 0;
}

double SignedDistance::signed_distance(const Eigen::Vector3d& p, const NearestOnMesh& foot) const {
  const bool is_behind = (p - foot.position).dot(normals_.at(foot.triangle, foot.feature)) < 0;
  return is_behind != is_inside_out_ ? -foot.distance_m : foot.distance_m;
}

double SignedDistance::at(const Eigen::Vector3d& p) const {
  const auto foot = tree_.nearest(p, std::numeric_limits<double>::infinity());
  SCANKNIT_CHECK(foot.has_value());
  return signed_distance(p, *foot);
}

std::vector<double> SignedDistance::at(std::span<const Eigen::Vector3d> points) const {
  constexpr std::size_t kGrain = 512;
  std::vector<double> distances_m(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      // The place that was nearest to one point bounds the distance of the next: less of the tree is
                      // searched, with the same result.
                      constexpr double kRounding = 1 + 1e-9;
                      std::optional<NearestOnMesh> foot;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const Eigen::Vector3d& p = points[i];
                        const double bound_m =
                            foot ? (p - foot->position).norm() * kRounding : std::numeric_limits<double>::infinity();
                        auto nearest = tree_.nearest(p, bound_m);
                        if (!nearest) nearest = tree_.nearest(p, std::numeric_limits<double>::infinity());
                        SCANKNIT_CHECK(nearest.has_value());
                        distances_m[i] = signed_distance(p, *nearest);
                        foot = nearest;
                      }
                    });
  return distances_m;
}

}  // namespace scanknit
