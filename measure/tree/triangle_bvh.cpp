#include "measure/tree/triangle_bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::size_t kStackSize = 64;  // median splits: the tree of 2^32 triangles has fewer than 32 levels

/// Returns 0 for a zero denominator: a degenerate triangle is treated as its first corner.
double ratio_or_zero(double numerator, double denominator) {
  return denominator > 0 ? numerator / denominator : 0;
}

struct NearestOnTriangle {
  Eigen::Vector3d position;
  TriangleFeature feature;
};

/// The nearest point of triangle abc, by the Voronoi region of a corner, an edge or the face that contains p (Ericson
/// 2005, "Real-Time Collision Detection", section 5.1.5).
NearestOnTriangle nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                      const Eigen::Vector3d& c) {
  using enum TriangleFeature;
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const double ab_a = ab.dot(p - a);
  const double ac_a = ac.dot(p - a);
  if (ab_a <= 0 && ac_a <= 0) return {a, kVertex0};
  const double ab_b = ab.dot(p - b);
  const double ac_b = ac.dot(p - b);
  if (ab_b >= 0 && ac_b <= ab_b) return {b, kVertex1};
  const double weight_c = ab_a * ac_b - ab_b * ac_a;  // barycentric weights times the squared doubled area
  if (weight_c <= 0 && ab_a >= 0 && ab_b <= 0) return {a + ratio_or_zero(ab_a, ab_a - ab_b) * ab, kEdge01};
  const double ab_c = ab.dot(p - c);
  const double ac_c = ac.dot(p - c);
  if (ac_c >= 0 && ab_c <= ac_c) return {c, kVertex2};
  const double weight_b = ab_c * ac_a - ab_a * ac_c;
  if (weight_b <= 0 && ac_a >= 0 && ac_c <= 0) return {a + ratio_or_zero(ac_a, ac_a - ac_c) * ac, kEdge20};
  const double weight_a = ab_b * ac_c - ab_c * ac_b;
  const double towards_c = ac_b - ab_b;
  const double towards_b = ab_c - ac_c;
  if (weight_a <= 0 && towards_c >= 0 && towards_b >= 0) {
    return {b + ratio_or_zero(towards_c, towards_c + towards_b) * (c - b), kEdge12};
  }
  const double sum = weight_a + weight_b + weight_c;
  return {a + ratio_or_zero(weight_b, sum) * ab + ratio_or_zero(weight_c, sum) * ac, kFace};
}

/// Moeller & Trumbore 1997. A small tolerance at the edges makes neighbours overlap, so that there is no gap between
/// them.
std::optional<double> intersect_triangle(const Ray& ray, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                         const Eigen::Vector3d& c) {
  constexpr double kSlack = 1e-9;
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d across = ray.direction.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return std::nullopt;  // the ray lies in the triangle's plane
  const Eigen::Vector3d from_a = ray.origin - a;
  const double u = from_a.dot(across) / determinant;
  if (!(u >= -kSlack && u <= 1 + kSlack)) return std::nullopt;
  const Eigen::Vector3d turned = from_a.cross(ab);
  const double v = ray.direction.dot(turned) / determinant;
  if (!(v >= -kSlack && u + v <= 1 + kSlack)) return std::nullopt;
  return ac.dot(turned) / determinant;
}

/// The distance at which the ray enters the box; infinity if it misses the box or enters beyond `max_t`.
double enter_box(const Eigen::AlignedBox3f& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse,
                 double max_t) {
  double enter = 0;
  double leave = max_t;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (static_cast<double>(box.min()[axis]) - origin[axis]) * inverse[axis];
    const double t1 = (static_cast<double>(box.max()[axis]) - origin[axis]) * inverse[axis];
    // fmin and fmax ignore the NaN of 0 * infinity (a ray in a face of the box).
    enter = std::fmax(enter, std::fmin(t0, t1));
    leave = std::fmin(leave, std::fmax(t0, t1));
  }
  constexpr double kSlack = 1e-12;
  return enter <= leave * (1 + kSlack) + kSlack ? enter : std::numeric_limits<double>::infinity();
}

}  // namespace

TriangleBvh::TriangleBvh(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
  SCANKNIT_CHECK(!mesh.triangles.empty());
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Eigen::Vector3f> centres;
  centres.reserve(order_.size());
  for (const Triangle& t : mesh.triangles) {
    centres.push_back((mesh.positions_m[t[0]] + mesh.positions_m[t[1]] + mesh.positions_m[t[2]]) / 3);
  }
  nodes_.reserve(order_.size());
  build(0, static_cast<std::uint32_t>(order_.size()), centres);
}

void TriangleBvh::build(std::uint32_t begin, std::uint32_t end, const std::vector<Eigen::Vector3f>& centres) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Eigen::AlignedBox3f box;
  Eigen::AlignedBox3f centre_box;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const std::uint32_t v : mesh_.triangles[order_[i]]) box.extend(mesh_.positions_m[v]);
    centre_box.extend(centres[order_[i]]);
  }
  nodes_[self].box = box;
  if (end - begin <= kLeafSize) {
    nodes_[self].first = begin;
    nodes_[self].count = end - begin;
    return;
  }
  Eigen::Index axis = 0;
  centre_box.sizes().maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {  // the index breaks ties, so that the order is unique
                     return std::pair(centres[a][axis], a) < std::pair(centres[b][axis], b);
                   });
  build(begin, middle, centres);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end, centres);
}

TriangleBvh::Corners TriangleBvh::corners(std::uint32_t triangle) const {
  const Triangle& t = mesh_.triangles[triangle];
  return {mesh_.positions_m[t[0]].cast<double>(), mesh_.positions_m[t[1]].cast<double>(),
          mesh_.positions_m[t[2]].cast<double>()};
}

std::optional<NearestOnMesh> TriangleBvh::nearest(const Eigen::Vector3d& p, double max_distance_m) const {
  std::optional<NearestOnMesh> best;
  double best_squared = max_distance_m * max_distance_m;
  const auto squared_distance = [&p](const Node& node) {
    const Eigen::Vector3d low = node.box.min().cast<double>() - p;
    const Eigen::Vector3d high = p - node.box.max().cast<double>();
    return low.cwiseMax(high).cwiseMax(0.0).squaredNorm();
  };
  struct Waiting {
    std::uint32_t node;
    double squared;
  };
  std::array<Waiting, kStackSize> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, squared_distance(nodes_[0])};
  while (depth > 0) {
    const Waiting top = stack[--depth];
    if (top.squared > best_squared) continue;
    const Node& node = nodes_[top.node];
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto [a, b, c] = corners(order_[i]);
      const NearestOnTriangle foot = nearest_on_triangle(p, a, b, c);
      const double squared = (foot.position - p).squaredNorm();
      if (squared > best_squared || (best && squared == best_squared)) continue;
      best_squared = squared;
      best = NearestOnMesh{0, foot.position, order_[i], foot.feature};
    }
    if (node.count > 0) continue;
    Waiting near{top.node + 1, squared_distance(nodes_[top.node + 1])};
    Waiting far{node.first, squared_distance(nodes_[node.first])};
    if (far.squared < near.squared) std::swap(near, far);
    SCANKNIT_CHECK(depth + 2 <= kStackSize);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  if (best) best->distance_m = std::sqrt(best_squared);
  return best;
}

std::optional<MeshHit> TriangleBvh::intersect(const Ray& ray, double max_t_m) const {
  const Eigen::Vector3d inverse = ray.direction.cwiseInverse();
  std::optional<MeshHit> first;
  double first_t = max_t_m;
  struct Waiting {
    std::uint32_t node;
    double enter;
  };
  std::array<Waiting, kStackSize> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, enter_box(nodes_[0].box, ray.origin, inverse, first_t)};
  while (depth > 0) {
    const Waiting top = stack[--depth];
    if (!(top.enter <= first_t)) continue;
    const Node& node = nodes_[top.node];
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto [a, b, c] = corners(order_[i]);
      const auto t = intersect_triangle(ray, a, b, c);
      if (!t || !(*t > 0) || *t > first_t || (first && *t == first_t)) continue;
      first_t = *t;
      first = MeshHit{*t, order_[i]};
    }
    if (node.count > 0) continue;
    Waiting near{top.node + 1, enter_box(nodes_[top.node + 1].box, ray.origin, inverse, first_t)};
    Waiting far{node.first, enter_box(nodes_[node.first].box, ray.origin, inverse, first_t)};
    if (far.enter < near.enter) std::swap(near, far);
    SCANKNIT_CHECK(depth + 2 <= kStackSize);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return first;
}

}  // namespace scanknit
