#include "finish/mesh_steps.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/mesh/triangle_fins.h"
#include "core/mesh/unused_vertices.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

constexpr int kRounds = 12;                      // most attempts, each keeping the faulty places of the one before
constexpr double kLargestErrorRatio = 8;         // limit, as a multiple of the error without kept triangles
constexpr double kMostKept = 2;                  // the result must have at least so many times the kept triangles
constexpr double kFirstStep = 0.5;               // first step: to this share of the triangles
constexpr double kLastStep = 0.97;               // stop when a step leaves more than this share
constexpr double kErrorSpent = 0.5;              // of the allowed error: the rest allows almost nothing
constexpr double kAnyError = 1e3;                // no limit, in extents of the mesh; its square must fit into a float
constexpr std::array kKeptReaches = {1.5, 0.5};  // times the longest edge at a faulty vertex
constexpr std::size_t kStride = sizeof(Eigen::Vector3f);

/// Twice the genus, summed over the pieces of a closed mesh.
std::ptrdiff_t twice_genus(const MeshCheck& check) {
  return 2 * static_cast<std::ptrdiff_t>(check.components) - static_cast<std::ptrdiff_t>(check.euler);
}

/// True when the simplified mesh is still manifold, closed and of the same genus if it was so before. Small pieces may
/// vanish: few triangles cannot represent many pieces.
bool keeps_topology(const MeshCheck& before, const MeshCheck& after) {
  return after.triangles > 0 && after.components <= before.components &&
         after.non_manifold_edges <= before.non_manifold_edges &&
         after.non_manifold_vertices <= before.non_manifold_vertices &&
         after.misoriented_edges <= before.misoriented_edges &&
         after.duplicate_triangles <= before.duplicate_triangles &&
         (!before.is_closed() || (after.is_closed() && twice_genus(after) == twice_genus(before)));
}

/// Collapses edges of the triangles that are not kept. Vertices keep their numbers: the mesh has the triangles of the
/// last attempt, the simplifier those from before.
class Simplifier {
 public:
  explicit Simplifier(Mesh& mesh) : mesh_(mesh), all_(std::move(mesh.triangles)), is_kept_(all_.size()) {}

  /// `error`: as a share of the mesh's extent. Returns the error that was reached.
  float run(std::size_t target, double error) {
    mesh_.triangles = {};
    std::vector<Triangle> kept, some;
    const std::size_t kept_count = this->kept();
    kept.reserve(kept_count);
    some.reserve(kept_count > 0 ? all_.size() - kept_count : 0);
    for (std::size_t i = 0; kept_count > 0 && i < all_.size(); ++i) (is_kept_[i] != 0 ? kept : some).push_back(all_[i]);
    const std::vector<Triangle>& loose = kept_count > 0 ? some : all_;
    const std::size_t wanted = 3 * std::min(target > kept_count ? target - kept_count : 0, loose.size());
    const unsigned options = kept_count > 0 ? static_cast<unsigned>(meshopt_SimplifyLockBorder) : 0u;
    float reached = 0;
    std::vector<Triangle> fewer(loose.size());
    if (!loose.empty()) {
      static_assert(sizeof(Triangle) == 3 * sizeof(Index));  // an array of triangles is one of indices
      const std::size_t indices = meshopt_simplify(fewer.front().data(), loose.front().data(), 3 * loose.size(),
                                                   mesh_.positions_m.front().data(), mesh_.positions_m.size(), kStride,
                                                   wanted, static_cast<float>(error), options, &reached);
      fewer.resize(indices / 3);
    }
    kept.insert(kept.end(), fewer.begin(), fewer.end());
    remove_fins(kept);
    mesh_.triangles = std::move(kept);
    return reached;
  }

  /// The triangles from before the simplification.
  [[nodiscard]] std::vector<Triangle> take_all() { return std::move(all_); }

  /// Keeps from now on the triangles round the mesh's faulty vertices. False when all of these are kept already.
  bool keep_round_faults(double kept_reach) {
    const std::vector<std::uint8_t> is_bad = non_manifold_vertices(mesh_);
    std::vector<float> reach(is_bad.size());
    for (const Triangle& t : mesh_.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const float length = (mesh_.positions_m[t[i]] - mesh_.positions_m[t[(i + 1) % 3]]).norm();
        for (const Index vertex : {t[i], t[(i + 1) % 3]})
          reach[vertex] = std::max(reach[vertex], static_cast<float>(kept_reach) * length);
      }
    }
    const std::vector<std::uint8_t> is_near = near_faults(is_bad, reach);
    bool has_grown = false;
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const Triangle& t = all_[i];
      if (is_kept_[i] != 0 || (is_near[t[0]] | is_near[t[1]] | is_near[t[2]]) == 0) continue;
      is_kept_[i] = 1;
      has_grown = true;
    }
    return has_grown;
  }

  [[nodiscard]] std::size_t kept() const {
    return static_cast<std::size_t>(std::count(is_kept_.begin(), is_kept_.end(), std::uint8_t{1}));
  }

 private:
  /// The vertices within `kept_reach` times its reach of a faulty vertex. Faulty vertices are found in a grid whose
  /// cells have the largest radius.
  [[nodiscard]] std::vector<std::uint8_t> near_faults(const std::vector<std::uint8_t>& is_bad,
                                                      const std::vector<float>& reach) const {
    float largest = 0;
    for (std::size_t v = 0; v < is_bad.size(); ++v) {
      if (is_bad[v] != 0) largest = std::max(largest, reach[v]);
    }
    std::vector<std::uint8_t> is_near(is_bad.size());
    if (!(largest > 0)) return is_near;
    using Cell = std::array<std::int64_t, 3>;
    const auto cell_of = [&](const Eigen::Vector3f& p) {
      const auto along = [&](float metres) { return static_cast<std::int64_t>(std::floor(metres / largest)); };
      return Cell{along(p.x()), along(p.y()), along(p.z())};
    };
    std::map<Cell, std::vector<Index>> faults;
    for (Index v = 0; v < is_bad.size(); ++v) {
      if (is_bad[v] != 0) faults[cell_of(mesh_.positions_m[v])].push_back(v);
    }
    tbb::parallel_for(std::size_t{0}, is_near.size(), [&](std::size_t v) {
      const Cell cell = cell_of(mesh_.positions_m[v]);
      for (int n = 0; n < 27; ++n) {
        const auto found = faults.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
        if (found == faults.end()) continue;
        for (const Index fault : found->second) {
          const float distance = (mesh_.positions_m[v] - mesh_.positions_m[fault]).norm();
          if (distance <= reach[fault]) is_near[v] = 1;
        }
      }
    });
    return is_near;
  }

  Mesh& mesh_;
  std::vector<Triangle> all_;
  std::vector<std::uint8_t> is_kept_;
};

/// True when at most a tenth is missing: further steps take as long and remove less.
bool is_near(std::size_t triangles, std::size_t wished) {
  return 10 * triangles <= 11 * wished + 20;
}

struct Simplified {
  double error_m = 0;
  std::size_t components = 0;
  std::vector<Triangle> before;  ///< the triangles that the mesh had
};

/// Simplifies to `target` triangles in one go, or as far as the error allows, and keeps the places that would become
/// faulty. Nothing, and the mesh as it was, when so much must be kept that the rest would be simplified too far.
std::optional<Simplified> simplify_at_once(const MeshCheck& before, std::size_t target, double max_error_m,
                                           double kept_reach, Mesh& mesh) {
  const auto extent =
      static_cast<double>(meshopt_simplifyScale(mesh.positions_m.front().data(), mesh.positions_m.size(), kStride));
  if (!(extent > 0)) return std::nullopt;
  const double error = std::min(max_error_m / extent, kAnyError);
  Simplifier simplifier(mesh);
  double free_error_m = 0;  // the error when nothing is kept
  for (int round = 0; round < kRounds; ++round) {
    Simplified result;
    result.error_m = static_cast<double>(simplifier.run(target, error)) * extent;
    if (round == 0) free_error_m = result.error_m;
    if (result.error_m > kLargestErrorRatio * free_error_m) break;
    const MeshCheck after = check_mesh(mesh);
    result.components = after.components;
    if (keeps_topology(before, after)) {
      result.before = simplifier.take_all();
      return result;
    }
    if (!simplifier.keep_round_faults(kept_reach)) break;
    if (kMostKept * static_cast<double>(simplifier.kept()) > static_cast<double>(after.triangles)) break;
  }
  mesh.triangles = simplifier.take_all();
  return std::nullopt;
}

std::optional<Simplified> simplify_at_once(const MeshCheck& before, std::size_t target, double max_error_m,
                                           Mesh& mesh) {
  for (const double kept_reach : kKeptReaches) {
    if (auto result = simplify_at_once(before, target, max_error_m, kept_reach, mesh)) return result;
  }
  return std::nullopt;
}

/// Simplifies in steps; each begins with the result of the one before. Each step makes fewer faults, and the places
/// that one step kept are free in the next. The errors of the steps add up.
Simplified simplify_in_steps(MeshCheck check, std::size_t target, double max_error_m, Mesh& mesh) {
  Simplified best{0, check.components, {}};
  for (double share = kFirstStep; share < kLastStep;) {
    const std::size_t triangles = mesh.triangles.size();
    const auto wanted = std::max(target, static_cast<std::size_t>(share * static_cast<double>(triangles)));
    auto next = simplify_at_once(check, wanted, max_error_m - best.error_m, mesh);
    const bool is_enough =
        next && static_cast<double>(mesh.triangles.size()) <= kLastStep * static_cast<double>(triangles);
    if (!is_enough) {
      if (next) mesh.triangles = std::move(next->before);
      share = (1 + share) / 2;
      continue;
    }
    best = {best.error_m + next->error_m, next->components, {}};
    drop_unused_vertices(mesh);
    check = check_mesh(mesh);
    if (is_near(mesh.triangles.size(), target)) break;
  }
  return best;
}

}  // namespace

std::size_t simplify_bytes(const Mesh& mesh) {
  constexpr std::size_t kOfATriangle =
      84;                                 // neighbours 24, collapses 18 and their order 6, copies 24 and the result 12
  constexpr std::size_t kOfAVertex = 86;  // quadric 44, position 12, the rest numbers
  return kOfATriangle * mesh.triangles.size() + kOfAVertex * mesh.positions_m.size();
}

MeshSimplified simplify_mesh(const SimplifyTarget& target, Mesh& mesh) {
  MeshSimplified result;
  result.triangles_before = result.triangles = mesh.triangles.size();
  if (mesh.empty() || (target.triangles && *target.triangles >= mesh.triangles.size())) return result;
  const MeshCheck before = check_mesh(mesh);
  const std::size_t triangles = target.triangles.value_or(0);
  const double max_error_m = target.max_error_m.value_or(std::numeric_limits<double>::infinity());
  auto best = simplify_at_once(before, triangles, max_error_m, mesh);
  const bool is_sound_at_once = best.has_value();
  if (!best) best = simplify_in_steps(before, triangles, max_error_m, mesh);
  result.triangles = mesh.triangles.size();
  result.pieces_lost = before.components - best->components;
  result.error_m = best->error_m;
  const bool is_done = target.triangles && result.triangles <= triangles + triangles / 100;  // 1 % too many is fine
  const bool is_error_spent = target.max_error_m && result.error_m > kErrorSpent * max_error_m;
  const bool is_as_far_as_goes = !target.triangles && is_sound_at_once;
  result.is_held_back = !is_done && !is_error_spent && !is_as_far_as_goes;
  if (result.triangles < result.triangles_before) {
    drop_unused_vertices(mesh);
  } else if (is_sound_at_once) {
    mesh.triangles = std::move(best->before);
  }
  return result;
}

}  // namespace scanknit
