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
#include <tuple>
#include <utility>
#include <vector>

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

/// Removes pairs of coincident triangles with opposite orientation. Collapses leave such fins, and the edge at which a
/// fin is attached has four sides. The surface is the same without them.
void remove_fins(Mesh& mesh) {
  struct Sorted {
    Index a, b, c;
    std::size_t triangle;
    bool is_even;  ///< the corners are an even permutation of the sorted ones
  };
  std::vector<Sorted> all;
  all.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle t = mesh.triangles[i];
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    all.push_back({t[0], std::min(t[1], t[2]), std::max(t[1], t[2]), i, t[1] < t[2]});
  }
  const auto key = [](const Sorted& s) { return std::tuple(s.a, s.b, s.c, s.triangle); };
  std::sort(all.begin(), all.end(), [&](const Sorted& x, const Sorted& y) { return key(x) < key(y); });
  std::vector<std::uint8_t> is_fin(mesh.triangles.size());
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Sorted& x = all[i - 1];
    const Sorted& y = all[i];
    if (x.a != y.a || x.b != y.b || x.c != y.c || x.is_even == y.is_even || is_fin[x.triangle] != 0) continue;
    is_fin[x.triangle] = is_fin[y.triangle] = 1;
  }
  std::vector<Triangle> rest;
  for (std::size_t i = 0; i < is_fin.size(); ++i) {
    if (is_fin[i] == 0) rest.push_back(mesh.triangles[i]);
  }
  mesh.triangles = std::move(rest);
}

/// Collapses edges of the triangles that are not kept. Vertices keep their numbers.
class Simplifier {
 public:
  explicit Simplifier(const Mesh& mesh) : mesh_(mesh), is_kept_(mesh.triangles.size()) {}

  /// `error`: as a share of the mesh's extent. Returns the error that was reached.
  float run(std::size_t target, double error, Mesh& smaller) const {
    std::vector<Index> loose;
    smaller = mesh_;
    smaller.triangles.clear();
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const Triangle& t = mesh_.triangles[i];
      if (is_kept_[i] != 0) {
        smaller.triangles.push_back(t);
      } else {
        loose.insert(loose.end(), t.begin(), t.end());
      }
    }
    const std::size_t kept = smaller.triangles.size();
    const std::size_t wanted = 3 * std::min(target > kept ? target - kept : 0, loose.size() / 3);
    const unsigned options = kept > 0 ? static_cast<unsigned>(meshopt_SimplifyLockBorder) : 0u;
    float reached = 0;
    std::vector<Index> fewer(loose.size());
    if (!loose.empty()) {
      fewer.resize(meshopt_simplify(fewer.data(), loose.data(), loose.size(), mesh_.positions_m.front().data(),
                                    mesh_.positions_m.size(), kStride, wanted, static_cast<float>(error), options,
                                    &reached));
    }
    for (std::size_t i = 0; i + 2 < fewer.size(); i += 3) {
      smaller.triangles.emplace_back(fewer[i], fewer[i + 1], fewer[i + 2]);
    }
    remove_fins(smaller);
    return reached;
  }

  /// Keeps from now on the triangles round the faulty vertices of `smaller`. False when all of these are kept already.
  bool keep_round_faults(const Mesh& smaller, double kept_reach) {
    const std::vector<std::uint8_t> is_bad = non_manifold_vertices(smaller);
    std::vector<float> reach(is_bad.size());
    for (const Triangle& t : smaller.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const float length = (mesh_.positions_m[t[i]] - mesh_.positions_m[t[(i + 1) % 3]]).norm();
        for (const Index vertex : {t[i], t[(i + 1) % 3]})
          reach[vertex] = std::max(reach[vertex], static_cast<float>(kept_reach) * length);
      }
    }
    const std::vector<std::uint8_t> is_near = near_faults(is_bad, reach);
    bool has_grown = false;
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const Triangle& t = mesh_.triangles[i];
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

  const Mesh& mesh_;
  std::vector<std::uint8_t> is_kept_;
};

/// True when at most a tenth is missing: further steps take as long and remove less.
bool is_near(std::size_t triangles, std::size_t wished) {
  return 10 * triangles <= 11 * wished + 20;
}

struct Simplified {
  Mesh mesh;
  double error_m = 0;
  std::size_t components = 0;
};

/// Simplifies to `target` triangles in one go, or as far as the error allows, and keeps the places that would become
/// faulty. Nothing when so much must be kept that the rest would be simplified too far.
std::optional<Simplified> simplify_at_once(const Mesh& mesh, const MeshCheck& before, std::size_t target,
                                           double max_error_m, double kept_reach) {
  const auto extent =
      static_cast<double>(meshopt_simplifyScale(mesh.positions_m.front().data(), mesh.positions_m.size(), kStride));
  if (!(extent > 0)) return std::nullopt;
  const double error = std::min(max_error_m / extent, kAnyError);
  Simplifier simplifier(mesh);
  double free_error_m = 0;  // the error when nothing is kept
  for (int round = 0; round < kRounds; ++round) {
    Simplified result;
    result.error_m = static_cast<double>(simplifier.run(target, error, result.mesh)) * extent;
    if (round == 0) free_error_m = result.error_m;
    if (result.error_m > kLargestErrorRatio * free_error_m) return std::nullopt;
    const MeshCheck after = check_mesh(result.mesh);
    result.components = after.components;
    if (keeps_topology(before, after)) return result;
    if (!simplifier.keep_round_faults(result.mesh, kept_reach)) return std::nullopt;
    if (kMostKept * static_cast<double>(simplifier.kept()) > static_cast<double>(after.triangles)) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<Simplified> simplify_at_once(const Mesh& mesh, const MeshCheck& before, std::size_t target,
                                           double max_error_m) {
  for (const double kept_reach : kKeptReaches) {
    if (auto result = simplify_at_once(mesh, before, target, max_error_m, kept_reach)) return result;
  }
  return std::nullopt;
}

/// Simplifies in steps; each begins with the result of the one before. Each step makes fewer faults, and the places
/// that one step kept are free in the next. The errors of the steps add up.
Simplified simplify_in_steps(Mesh mesh, MeshCheck check, std::size_t target, double max_error_m) {
  Simplified best{std::move(mesh), 0, check.components};
  for (double share = kFirstStep; share < kLastStep;) {
    const std::size_t triangles = best.mesh.triangles.size();
    const auto wanted = std::max(target, static_cast<std::size_t>(share * static_cast<double>(triangles)));
    auto next = simplify_at_once(best.mesh, check, wanted, max_error_m - best.error_m);
    if (!next || static_cast<double>(next->mesh.triangles.size()) > kLastStep * static_cast<double>(triangles)) {
      share = (1 + share) / 2;
      continue;
    }
    next->error_m += best.error_m;
    best = *std::move(next);
    drop_unused_vertices(best.mesh);
    check = check_mesh(best.mesh);
    if (is_near(best.mesh.triangles.size(), target)) break;
  }
  return best;
}

}  // namespace

MeshSimplified simplify_mesh(const SimplifyTarget& target, Mesh& mesh) {
  MeshSimplified result;
  result.triangles_before = result.triangles = mesh.triangles.size();
  if (mesh.empty() || (target.triangles && *target.triangles >= mesh.triangles.size())) return result;
  const MeshCheck before = check_mesh(mesh);
  const std::size_t triangles = target.triangles.value_or(0);
  const double max_error_m = target.max_error_m.value_or(std::numeric_limits<double>::infinity());
  auto best = simplify_at_once(mesh, before, triangles, max_error_m);
  const bool is_sound_at_once = best.has_value();
  if (!best) best = simplify_in_steps(mesh, before, triangles, max_error_m);
  result.triangles = best->mesh.triangles.size();
  result.pieces_lost = before.components - best->components;
  result.error_m = best->error_m;
  const bool is_done = target.triangles && result.triangles <= triangles + triangles / 100;  // 1 % too many is fine
  const bool is_error_spent = target.max_error_m && result.error_m > kErrorSpent * max_error_m;
  const bool is_as_far_as_goes = !target.triangles && is_sound_at_once;
  result.is_held_back = !is_done && !is_error_spent && !is_as_far_as_goes;
  if (result.triangles < result.triangles_before) {
    drop_unused_vertices(best->mesh);
    mesh = std::move(best->mesh);
  }
  return result;
}

}  // namespace scanknit
