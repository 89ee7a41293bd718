// ScanModel: one scan in the form that registration uses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/pose.h"
#include "core/range_scan.h"
#include "fusion/range/range_surface.h"
#include "fusion/range/range_view.h"

namespace scanknit {

/// Points of a surface with outward unit normals.
struct OrientedPoints {
  std::vector<Eigen::Vector3f> points_m;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::uint8_t> is_rim;  ///< the surface ends there, so the nearest point may be missing
  [[nodiscard]] std::size_t size() const { return points_m.size(); }
};

/// A view from one position, which shows what is free space.
struct ModelSight {
  RangeView view;
  Pose T_scan_view = Pose::Identity();
};

/// In the scan's own frame.
struct ScanModel {
  std::string name;
  OrientedPoints all;
  double spacing_m = 0;            ///< approximate distance of neighbouring points
  std::vector<ModelSight> sights;  ///< empty: the scanner's position is unknown
};

/// The model of a range scan: the points of its surface. `sights` has its view.
[[nodiscard]] ScanModel model_of(const RangeScan& scan, const RangeSurface& surface);

/// The model of a mesh: its vertices, with their normals, else with those of the triangles.
[[nodiscard]] ScanModel model_of(const Mesh& mesh, std::string name);

/// The sampling of scans: the same for all scans that are compared.
struct AlignScale {
  double coarse_m = 0;  ///< spacing of points for the coarse search
  double fine_m = 0;    ///< spacing of points for fine registration
};

/// Chooses the scale from the size of the smallest scan and the spacing of points. Zero without points.
[[nodiscard]] AlignScale choose_scale(const std::vector<ScanModel>& models);

/// Keeps one mean point for each cube of `cell_m` and each of six directions of the normal. The order is the same for
/// any number of threads.
[[nodiscard]] OrientedPoints thin_out(const OrientedPoints& points, double cell_m);

}  // namespace scanknit
