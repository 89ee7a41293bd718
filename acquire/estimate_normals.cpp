// Normals of a depth picture: least-squares planes in inverse depth over a star of pixels.
//
// A plane is linear in inverse depth over the picture: 1/z = a u + b v + c. With u = fx X/Z + cx and v = fy Y/Z + cy
// that is 1 = (a fx) X + (b fy) Y + (a cx + b cy + c) Z: the bracketed numbers are the plane's normal, up to length.
// The fit is linear, exact for planes of any slope, and holds for negative fy as it stands.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "acquire/depth_filter.h"
#include "acquire/depth_rows.h"
#include "acquire/inverse_depth.h"
#include "core/check.h"

namespace scanknit {

Image<Eigen::Vector3f> estimate_normals(const DepthImage& depth_m, const CameraIntrinsics& intrinsics,
                                        const NoiseModel& noise) {
  SCANKNIT_CHECK(intrinsics.is_valid());
  Image<Eigen::Vector3f> normals(depth_m.width(), depth_m.height(), Eigen::Vector3f::Zero());
  const InverseDepth inverse(depth_m);
  const NormalContext context(intrinsics, noise);
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    std::array<Eigen::Vector3f, kPixelGroup> group;
    for (int x = 0; x < depth_m.width(); x += kPixelGroup) {
      find_group_normals(context, inverse.at(x, y), inverse.pitch(), x, y, group.data());
      std::copy_n(group.begin(), std::min(kPixelGroup, depth_m.width() - x), &normals.at(x, y));
    }
  });
  return normals;
}

}  // namespace scanknit
