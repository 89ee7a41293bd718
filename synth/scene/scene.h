// SyntheticScene: a world with an exactly known surface, to scan without a scanner.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"
#include "measure/tree/ray.h"

namespace scanknit {

/// A point of the surface. `part` is the solid or triangle that it belongs to; `normal` is unit and points outwards.
struct SurfacePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
  std::size_t part = 0;
};

/// What a surface does with the near-infrared light (800 to 950 nm) of a depth sensor.
struct SurfaceMaterial {
  float reflectivity = 0.6f;  ///< share that comes back in all directions; paper 0.8, black cloth 0.05, nothing 0
  float gloss = 0;            ///< from 0, matt, to 1, a mirror
  friend bool operator==(const SurfaceMaterial&, const SurfaceMaterial&) = default;
};

/// T_world_camera at the position s of the path, 0 <= s <= 1.
using CameraPath = std::function<Pose(double s)>;

/// World: metres, right-handed, y down and z away, as a camera that stands upright sees it. Free space is where
/// distance() > 0. Immutable, and safe to read from many threads at once.
class SyntheticScene {
 public:
  SyntheticScene(std::string name, CameraPath path, int default_frames)
      : name_(std::move(name)), path_(std::move(path)), default_frames_(default_frames) {}
  virtual ~SyntheticScene() = default;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int default_frames() const { return default_frames_; }
  [[nodiscard]] const CameraPath& path() const { return path_; }

  /// Distance along the ray to the first surface within `max_t_m`, exact to 1e-7 m. The origin is in free space.
  [[nodiscard]] virtual std::optional<double> intersect(const Ray& ray, double max_t_m) const = 0;

  /// Signed distance to the surface, metres, positive in free space. Exact in free space; inside matter it has the
  /// right sign and never exceeds the true distance.
  [[nodiscard]] virtual double distance(const Eigen::Vector3d& p_world) const = 0;

  /// The surface point nearest to `p_world`. Exact in free space and to 1e-6 m within a few millimetres of the surface
  /// on the inner side, seams between solids included.
  [[nodiscard]] virtual SurfacePoint nearest(const Eigen::Vector3d& p_world) const = 0;

  /// sRGB, each channel in [0, 1]. Independent of the viewer, so that photometric tracking works.
  [[nodiscard]] virtual Eigen::Vector3d colour(const SurfacePoint& point) const = 0;

  [[nodiscard]] virtual SurfaceMaterial material(const SurfacePoint&) const { return {}; }

  /// A box that contains the whole surface.
  [[nodiscard]] virtual Eigen::AlignedBox3d bounds() const = 0;

  /// The triangles of the surface; null for an analytic scene.
  [[nodiscard]] virtual const Mesh* mesh() const { return nullptr; }

  /// Unsigned distance to the surface, as exact as nearest().
  [[nodiscard]] double surface_distance(const Eigen::Vector3d& p_world) const {
    return (nearest(p_world).position - p_world).norm();
  }
  /// Unit outward normal at the surface point nearest to `p_world`.
  [[nodiscard]] Eigen::Vector3d normal(const Eigen::Vector3d& p_world) const { return nearest(p_world).normal; }

 private:
  std::string name_;
  CameraPath path_;
  int default_frames_;
};

/// One of kSceneNames (scene_names.h). Error kUsage: there is no such scene; the message lists all scenes.
[[nodiscard]] Result<std::unique_ptr<SyntheticScene>> make_scene(std::string_view name);

/// A scene of one closed mesh on a turntable. The mesh is centred, turned so that its `up` axis is the world's -y, and
/// scaled so that its longest side measures `size_m` metres; mesh() gives the result. Reverses the triangles of an
/// inside-out mesh. Errors (kMesh): empty, not closed, not manifold, a value that is not finite; kUsage: size_m not
/// above 0 or over 100.
[[nodiscard]] Result<std::unique_ptr<SyntheticScene>> make_mesh_scene(Mesh mesh, double size_m = 0.2,
                                                                      UpAxis up = UpAxis::kY);

/// A scene of a mesh exactly as it is (what ground_truth.ply holds). Same errors.
[[nodiscard]] Result<std::unique_ptr<SyntheticScene>> make_mesh_scene_as_is(Mesh mesh);

/// `frames` poses T_world_camera along the scene's path, rigid to 1e-12; frames <= 0 means the scene's default. A path
/// that closes does not repeat its first pose at the end.
[[nodiscard]] std::vector<Pose> camera_path(const SyntheticScene& scene, int frames);

}  // namespace scanknit
