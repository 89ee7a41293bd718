// Statistical outlier removal on the points of one frame, by PCL.
#pragma once

#include "core/camera.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// Sets depth to 0 if the mean distance of its point to the `neighbours` nearest points is more than `std_multiplier`
/// standard deviations above the frame's mean (Rusu et al. 2008, "Towards 3D point cloud based object maps for
/// household environments"). neighbours <= 0, or fewer points than that: unchanged.
/// Error (kInternal): the module for PCL is missing (acquire/pcl/acquire_pcl.h).
[[nodiscard]] Result<DepthImage> remove_statistical_outliers(const DepthImage& depth_m,
                                                             const CameraIntrinsics& intrinsics, int neighbours,
                                                             double std_multiplier);

}  // namespace scanknit
