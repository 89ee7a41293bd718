#include "finish/simplify_mesh.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "core/unused_vertices.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

constexpr int kAttempts = 48;
constexpr int kRounds = 6;           // of keeping what went wrong, for one wish
constexpr double kNextTarget = 1.3;  // times the triangles of the attempt before
constexpr double kNextError = 0.6;
constexpr double kKeptReach = 1.5;  // of the longest edge at a vertex that went wrong
constexpr std::size_t kStride = sizeof(Eigen::Vector3f);

/// Twice the holes of a ring, summed over the pieces of a closed mesh.
std::ptrdiff_t twice_genus(const MeshCheck& check) {
  return 2 * static_cast<std::ptrdiff_t>(check.components) - static_cast<std::ptrdiff_t>(check.euler);
}

/// Nothing that the mesh promised is broken. Small pieces may vanish: few triangles do not hold many.
bool keeps_promises(const MeshCheck& before, const MeshCheck& after) {
  return after.triangles > 0 && after.components <= before.components &&
         after.non_manifold_edges <= before.non_manifold_edges &&
         after.non_manifold_vertices <= before.non_manifold_vertices &&
         after.misoriented_edges <= before.misoriented_edges &&
         after.duplicate_triangles <= before.duplicate_triangles &&
         (!before.is_closed() || (after.is_closed() && twice_genus(after) == twice_genus(before)));
}

/// Removes triangles that lie back to back: collapsed edges leave such fins, with a third and a fourth side on the edge
/// that they hang on. Without them the surface is the same.
void remove_fins(Mesh& mesh) {
  struct Sorted {
    Index a, b, c;
    std::size_t triangle;
    bool is_even;  ///< an even permutation of the sorted corners
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

/// Collapses edges among the triangles that are not kept as they are. Vertices keep their numbers.
class Simplifier {
 public:
  explicit Simplifier(const Mesh& mesh) : mesh_(mesh), is_kept_(mesh.triangles.size()) {}

  /// `error`: as a part of the mesh's extent. Returns what was reached.
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

  /// From now on the triangles round what went wrong in `smaller` stay as they are. False when all of them did already.
  bool keep_round_faults(const Mesh& smaller) {
    const std::vector<std::uint8_t> is_bad = non_manifold_vertices(smaller);
    std::vector<float> reach(is_bad.size());
    for (const Triangle& t : smaller.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const float length = (mesh_.positions_m[t[i]] - mesh_.positions_m[t[(i + 1) % 3]]).norm();
        for (const Index vertex : {t[i], t[(i + 1) % 3]}) reach[vertex] = std::max(reach[vertex], length);
      }
    }
    std::vector<Index> faults;
    for (Index v = 0; v < is_bad.size(); ++v) {
      if (is_bad[v] != 0) faults.push_back(v);
    }
    std::vector<std::uint8_t> is_near(is_bad.size());
    tbb::parallel_for(std::size_t{0}, is_near.size(), [&](std::size_t v) {
      for (const Index fault : faults) {
        const float distance = (mesh_.positions_m[v] - mesh_.positions_m[fault]).norm();
        if (distance <= static_cast<float>(kKeptReach) * reach[fault]) is_near[v] = 1;
      }
    });
    bool has_grown = false;
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const Triangle& t = mesh_.triangles[i];
      if (is_kept_[i] != 0 || (is_near[t[0]] | is_near[t[1]] | is_near[t[2]]) == 0) continue;
      is_kept_[i] = 1;
      has_grown = true;
    }
    return has_grown;
  }

  void let_go() { std::fill(is_kept_.begin(), is_kept_.end(), std::uint8_t{0}); }

 private:
  const Mesh& mesh_;
  std::vector<std::uint8_t> is_kept_;
};

/// A tenth more than was wished is as good as it.
bool is_near(std::size_t triangles, double wished) {
  return 10 * static_cast<double>(triangles) <= 11 * wished + 20;
}

}  // namespace

MeshSimplified simplify_mesh(const SimplifyWish& wish, Mesh& mesh) {
  MeshSimplified result;
  result.triangles_before = result.triangles = mesh.triangles.size();
  if (mesh.empty() || (wish.triangles && *wish.triangles >= mesh.triangles.size())) return result;
  const MeshCheck before = check_mesh(mesh);
  const auto extent =
      static_cast<double>(meshopt_simplifyScale(mesh.positions_m.front().data(), mesh.positions_m.size(), kStride));
  if (!(extent > 0)) return result;

  Simplifier simplifier(mesh);
  auto target = static_cast<double>(wish.triangles.value_or(0));
  double error = wish.max_error_m ? *wish.max_error_m / extent : 1e3;  // its square must be a float
  Mesh best = mesh;
  double best_error = 0;
  std::size_t best_components = before.components;
  int rounds = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Mesh smaller;
    const float reached = simplifier.run(static_cast<std::size_t>(target), error, smaller);
    const std::size_t triangles = smaller.triangles.size();
    const MeshCheck after = check_mesh(smaller);
    const bool is_sound = keeps_promises(before, after);
    if (is_sound && triangles < best.triangles.size()) {
      best = std::move(smaller);
      best_error = static_cast<double>(reached) * extent;
      best_components = after.components;
    }
    // Where too much had to stay as it was, more is won by asking for less.
    if (is_sound && (!wish.triangles || wish.max_error_m || is_near(triangles, target))) break;
    if (!is_sound && rounds++ < kRounds && simplifier.keep_round_faults(smaller)) continue;
    rounds = 0;
    simplifier.let_go();
    target = kNextTarget * std::max({target, is_sound ? 0.0 : static_cast<double>(triangles), 1.0});
    if (target >= static_cast<double>(best.triangles.size())) break;
    if (!wish.triangles) error *= kNextError;
  }
  result.triangles = best.triangles.size();
  result.pieces_lost = before.components - best_components;
  result.error_m = best_error;
  // Collapses stop a triangle or two from the wish at best.
  result.is_held_back = wish.triangles
                            ? !wish.max_error_m && !is_near(result.triangles, static_cast<double>(*wish.triangles))
                            : result.triangles == result.triangles_before;
  if (result.triangles < result.triangles_before) {
    drop_unused_vertices(best);
    mesh = std::move(best);
  }
  return result;
}

}  // namespace scanknit
