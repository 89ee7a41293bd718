#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/rotation.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/scene.h"
#include "synth/scene/texture.h"
#include "synth/scene/triangle_bvh.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr int kDefaultFrames = 300;

std::array<Vector3d, 3> corners(const Mesh& mesh, const Triangle& t) {
  return {mesh.positions_m[t[0]].cast<double>(), mesh.positions_m[t[1]].cast<double>(),
          mesh.positions_m[t[2]].cast<double>()};
}

/// The unit normal; zero for a triangle without area.
Vector3d face_normal(const Mesh& mesh, const Triangle& t) {
  const auto [a, b, c] = corners(mesh, t);
  return (b - a).cross(c - a).stableNormalized();
}

/// Normals that distinguish outside from inside at any nearest point of a closed mesh: the angle-weighted pseudonormals
/// of Baerentzen & Aanaes 2005, "Signed Distance Computation Using the Angle Weighted Pseudonormal".
class Pseudonormals {
 public:
  explicit Pseudonormals(const Mesh& mesh) : mesh_(mesh) {
    faces_.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) faces_.push_back(face_normal(mesh, t));
    add_edges();
    add_vertices();
  }

  [[nodiscard]] const Vector3d& face(std::uint32_t triangle) const { return faces_[triangle]; }

  [[nodiscard]] const Vector3d& at(std::uint32_t triangle, TriangleFeature feature) const {
    switch (feature) {
      case TriangleFeature::kVertex0: return vertices_[mesh_.triangles[triangle][0]];
      case TriangleFeature::kVertex1: return vertices_[mesh_.triangles[triangle][1]];
      case TriangleFeature::kVertex2: return vertices_[mesh_.triangles[triangle][2]];
      case TriangleFeature::kEdge01: return edges_[triangle][0];
      case TriangleFeature::kEdge12: return edges_[triangle][1];
      case TriangleFeature::kEdge20: return edges_[triangle][2];
      case TriangleFeature::kFace: break;
    }
    return faces_[triangle];
  }

 private:
  void add_edges() {
    struct Side {
      std::pair<std::uint32_t, std::uint32_t> edge;
      std::uint32_t triangle;
      std::size_t number;
    };
    std::vector<Side> sides;
    sides.reserve(3 * faces_.size());
    for (std::uint32_t i = 0; i < faces_.size(); ++i) {
      const Triangle& t = mesh_.triangles[i];
      for (std::size_t k = 0; k < 3; ++k) sides.push_back({std::minmax(t[k], t[(k + 1) % 3]), i, k});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::pair(a.edge, a.triangle) < std::pair(b.edge, b.triangle);
    });
    edges_.resize(faces_.size());
    for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {  // closed and manifold: sides come in pairs
      const Vector3d sum = faces_[sides[i].triangle] + faces_[sides[i + 1].triangle];
      edges_[sides[i].triangle][sides[i].number] = sum;
      edges_[sides[i + 1].triangle][sides[i + 1].number] = sum;
    }
  }

  void add_vertices() {
    vertices_.assign(mesh_.positions_m.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const auto p = corners(mesh_, mesh_.triangles[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d to_next = p[(k + 1) % 3] - p[k];
        const Vector3d to_last = p[(k + 2) % 3] - p[k];
        const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
        vertices_[mesh_.triangles[i][k]] += angle * faces_[i];
      }
    }
  }

  const Mesh& mesh_;
  std::vector<Vector3d> faces_;
  std::vector<std::array<Vector3d, 3>> edges_;
  std::vector<Vector3d> vertices_;
};

class MeshScene final : public SyntheticScene {
 public:
  MeshScene(Mesh mesh, CameraPath path)
      : SyntheticScene("mesh", std::move(path), kDefaultFrames),
        mesh_(std::move(mesh)),
        bvh_(mesh_),
        pseudonormals_(mesh_) {
    for (const Eigen::Vector3f& p : mesh_.positions_m) bounds_.extend(p.cast<double>());
    texture_.period_m = bounds_.sizes().maxCoeff() / 14;
  }

  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const override {
    const auto hit = bvh_.intersect(ray, max_t_m);
    return hit ? std::optional(hit->t_m) : std::nullopt;
  }

  [[nodiscard]] double distance(const Vector3d& p_world) const override {
    const NearestOnMesh foot = foot_of(p_world);
    const double side = (p_world - foot.position).dot(pseudonormals_.at(foot.triangle, foot.feature));
    return side < 0 ? -foot.distance_m : foot.distance_m;
  }

  [[nodiscard]] SurfacePoint nearest(const Vector3d& p_world) const override {
    const NearestOnMesh foot = foot_of(p_world);
    return {foot.position, pseudonormals_.face(foot.triangle), foot.triangle};
  }

  [[nodiscard]] Vector3d colour(const SurfacePoint& point) const override {
    if (mesh_.colours.empty()) return texture_colour(texture_, point.position);
    SCANKNIT_CHECK(point.part < mesh_.triangles.size());
    const Triangle& t = mesh_.triangles[point.part];
    const auto [a, b, c] = corners(mesh_, t);
    const Vector3d normal = (b - a).cross(c - a);
    const double doubled_area = normal.squaredNorm();
    if (doubled_area == 0) return rgb(t[0]);
    const double u = (c - b).cross(point.position - b).dot(normal) / doubled_area;
    const double v = (a - c).cross(point.position - c).dot(normal) / doubled_area;
    return (u * rgb(t[0]) + v * rgb(t[1]) + (1 - u - v) * rgb(t[2])).cwiseMax(0.0).cwiseMin(1.0);
  }

  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }
  [[nodiscard]] const Mesh* mesh() const override { return &mesh_; }

 private:
  [[nodiscard]] NearestOnMesh foot_of(const Vector3d& p_world) const {
    const auto foot = bvh_.nearest(p_world, std::numeric_limits<double>::infinity());
    SCANKNIT_CHECK(foot.has_value());
    return *foot;
  }
  [[nodiscard]] Vector3d rgb(std::uint32_t vertex) const {
    const Rgb8& c = mesh_.colours[vertex];
    return Vector3d(c.r, c.g, c.b) / 255;
  }

  Mesh mesh_;
  TriangleBvh bvh_;
  Pseudonormals pseudonormals_;
  Eigen::AlignedBox3d bounds_;
  Texture texture_;
};

/// Rotation that takes `up` to the world's -y.
Eigen::Matrix3d upright(UpAxis up) {
  const auto from = [up]() -> Vector3d {
    switch (up) {
      case UpAxis::kX: return Vector3d::UnitX();
      case UpAxis::kY: return Vector3d::UnitY();
      case UpAxis::kZ: return Vector3d::UnitZ();
      case UpAxis::kMinusX: return -Vector3d::UnitX();
      case UpAxis::kMinusY: return -Vector3d::UnitY();
      case UpAxis::kMinusZ: return -Vector3d::UnitZ();
    }
    return Vector3d::UnitY();
  }();
  // For y up: half a turn about x, which keeps left and right.
  if (from == Vector3d::UnitY()) return Vector3d(1, -1, -1).asDiagonal();
  return rotation_between(from, -Vector3d::UnitY()).toRotationMatrix();
}

Result<void> check_closed(const Mesh& mesh) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMesh, what, "mesh scene"}; };
  if (mesh.empty()) return refuse("the mesh has no triangles");
  const MeshCheck check = check_mesh(mesh);
  if (!check.is_well_formed) return refuse("the mesh has an index out of range or a value that is not finite");
  if (!check.is_closed()) {
    return refuse("the mesh is not closed: " + std::to_string(check.boundary_edges) +
                  " boundary edges, expected 0; close it first");
  }
  if (!check.is_manifold()) {
    return refuse("the mesh is not manifold: " + std::to_string(check.non_manifold_edges) + " edges, " +
                  std::to_string(check.non_manifold_vertices) + " vertices, " +
                  std::to_string(check.misoriented_edges) + " badly oriented edges, expected 0");
  }
  return {};
}

void turn_outside_out(Mesh& mesh) {
  if (signed_volume_m3(mesh) >= 0) return;
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace

Result<std::unique_ptr<SyntheticScene>> make_mesh_scene_as_is(Mesh mesh) {
  if (auto closed = check_closed(mesh); !closed) return closed.error();
  turn_outside_out(mesh);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.positions_m) box.extend(p);
  // The plan's axes seen from the world: x, z, -y.
  const Vector3d centre = T_world_plan().inverse() * box.center().cast<double>();
  const TurntablePath path{centre, 3 * static_cast<double>(box.sizes().maxCoeff()), 3};
  return std::unique_ptr<SyntheticScene>(std::make_unique<MeshScene>(std::move(mesh), turntable_path(path)));
}

Result<std::unique_ptr<SyntheticScene>> make_mesh_scene(Mesh mesh, double size_m, UpAxis up) {
  if (!(size_m > 0 && size_m <= 100)) {
    return Error{ErrorCode::kUsage, "size " + std::to_string(size_m) + " m, expected above 0 and at most 100 m"};
  }
  if (auto closed = check_closed(mesh); !closed) return closed.error();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : mesh.positions_m) box.extend(p.cast<double>());
  const double extent = box.sizes().maxCoeff();
  if (!(extent > 0)) return Error{ErrorCode::kMesh, "the mesh is a single point", "mesh scene"};
  const Eigen::Matrix3d turn = size_m / extent * upright(up);
  for (Eigen::Vector3f& p : mesh.positions_m) p = (turn * (p.cast<double>() - box.center())).cast<float>();
  mesh.normals.clear();
  return make_mesh_scene_as_is(std::move(mesh));
}

}  // namespace scanknit
