// Normals of a depth picture: least-squares planes in inverse depth over a star of pixels.
//
// A plane is linear in inverse depth over the picture: 1/z = a u + b v + c. With u = fx X/Z + cx and v = fy Y/Z + cy
// that is 1 = (a fx) X + (b fy) Y + (a cx + b cy + c) Z: the bracketed numbers are the plane's normal, up to length.
// The fit is linear, exact for planes of any slope, and holds for negative fy as it stands.
#include <tbb/parallel_for.h>

#include "acquire/filter/depth_filter.h"
#include "acquire/filter/depth_rows.h"
#include "acquire/filter/inverse_depth.h"
#include "core/check.h"

namespace scanknit {

Image<Eigen::Vector3f> estimate_normals(const DepthImage& depth_m, const CameraIntrinsics& intrinsics,
                                        const NoiseModel& noise) {
  SCANKNIT_CHECK(intrinsics.is_valid());
  auto normals = Image<Eigen::Vector3f>::uninitialised(depth_m.width(), depth_m.height());
  const InverseDepth inverse(depth_m);
  const NormalContext context(intrinsics, noise);
  tbb::parallel_for(0, depth_m.height(),
                    [&](int y) { find_row_normals(context, inverse.at(0, y), inverse.pitch(), y, normals.row(y)); });
  return normals;
}

}  // namespace scanknit
