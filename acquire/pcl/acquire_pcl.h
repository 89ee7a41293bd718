// What PCL does for this room: in a module, libscanknit_acquire_pcl.so, since PCL brings many libraries with it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/pcl/pcd_header.h"
#include "core/camera.h"
#include "core/system/module.h"

namespace scanknit {

/// As PCL's image grabber wrote them; nothing where PCL cannot read it.
struct PclzfParameters {
  std::optional<CameraIntrinsics> depth, colour;  ///< of pictures of 1 x 1: the file does not know their size
  double metres_per_unit = 0;                     ///< as it is
};

struct AcquirePcl {
  /// The bytes of all points of a PCD file, header.point_bytes each; `header` is parse_pcd_header()'s. Nothing where
  /// PCL refuses the file, or reads its header in another way.
  std::optional<std::vector<std::uint8_t>> (*read_pcd_points)(std::span<const std::byte> file, const PcdHeader& header);

  /// LZF data to `unpacked_bytes` bytes. Nothing where they are corrupt, or of another size.
  std::optional<std::vector<char>> (*unpack_lzf)(std::span<const std::byte> packed, std::size_t unpacked_bytes);

  PclzfParameters (*read_pclzf_parameters)(const std::string& xml);

  /// As remove_statistical_outliers(): numbers of the points that stay, ascending. More points than `neighbours` > 0.
  std::vector<int> (*find_inliers)(const std::vector<Eigen::Vector3f>& points_m, int neighbours, double std_multiplier);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const AcquirePcl*> load_acquire_pcl() {
  return load_module<AcquirePcl>("acquire_pcl",
                                 "Install scanknit again; it needs Debian's libpcl-io1.13 and libpcl-filters1.13");
}

}  // namespace scanknit
