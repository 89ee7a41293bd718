// What PCL does for this room: in a module, libscanknit_finish_pcl.so, since PCL brings many libraries with it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/system/module.h"
#include "finish/mesh_steps.h"

namespace scanknit {

struct FinishPcl {
  /// The plane ax + by + cz + d = 0, given as (a, b, c, d), that most of the points lie on, by RANSAC with a fixed
  /// seed. Nothing where no three of them lie on a plane that `search` allows.
  std::optional<Eigen::Vector4d> (*find_plane)(const std::vector<Eigen::Vector3f>& points_m,
                                               const GroundSearch& search);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const FinishPcl*> load_finish_pcl() {
  return load_module<FinishPcl>("finish_pcl", "Install scanknit again; it needs Debian's libpcl-sample-consensus1.13");
}

}  // namespace scanknit
