// ScanModel: one scan as registration reads it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/pose.h"
#include "core/range_scan.h"
#include "fusion/integrate/range_surface.h"
#include "fusion/integrate/range_view.h"

namespace scanknit {

/// Points of a surface with unit normals out of it.
struct OrientedPoints {
  std::vector<Eigen::Vector3f> points_m;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::uint8_t> is_rim;  ///< the surface ends there: what is nearest to it may be missing
  [[nodiscard]] std::size_t size() const { return points_m.size(); }
};

/// Something that was looked at from one place, and what is free space by that.
struct ModelSight {
  RangeView view;
  Pose T_scan_view = Pose::Identity();
};

/// In the scan's own frame.
struct ScanModel {
  std::string name;
  OrientedPoints all;
  double spacing_m = 0;            ///< between neighbouring points, about
  std::vector<ModelSight> sights;  ///< empty: nobody knows from where it was seen
};

/// Of a range scan: the points of its surface. `sights` has its view.
[[nodiscard]] ScanModel model_of(const RangeScan& scan, const RangeSurface& surface);

/// Of a mesh: its vertices, with the normals that they have, else those of the triangles.
[[nodiscard]] ScanModel model_of(const Mesh& mesh, std::string name);

/// How finely scans are looked at: the same for all that are compared.
struct AlignScale {
  double coarse_m = 0;  ///< between points for finding where a scan belongs
  double fine_m = 0;    ///< ... and for placing it exactly
};

/// By the size of the scans (the smallest one counts) and the spacing of their points. Zero without points.
[[nodiscard]] AlignScale choose_scale(const std::vector<ScanModel>& models);

/// One point for each cube of `cell_m` and each of six directions of the normal: their mean. The same order whatever
/// the number of threads.
[[nodiscard]] OrientedPoints thin_out(const OrientedPoints& points, double cell_m);

}  // namespace scanknit
