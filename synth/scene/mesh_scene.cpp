#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/rotation.h"
#include "measure/tree/pseudonormals.h"
#include "measure/tree/triangle_bvh.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/scene.h"
#include "synth/scene/texture.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr int kDefaultFrames = 300;

std::array<Vector3d, 3> corners(const Mesh& mesh, const Triangle& t) {
  return {mesh.positions_m[t[0]].cast<double>(), mesh.positions_m[t[1]].cast<double>(),
          mesh.positions_m[t[2]].cast<double>()};
}

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
