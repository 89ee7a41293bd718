// PagedVolume: a volume that is larger than its memory. What the camera does not see now is in files.
#pragma once

#include <openvdb/math/Coord.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/fusion_config.h"
#include "fusion/integrate/integrate_part.h"
#include "fusion/volume/region_set.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// A page is the file of a region of 64^3 voxels. When the memory is full, the regions that the frame does not change
/// become pages; when a frame may change a page, it is read again before. As no block depends on another, every block
/// has the very bits that it would have in one volume.
class PagedVolume {
 public:
  /// `folder` must be there, and have room for the whole volume. Errors: those of TsdfVolume::create().
  [[nodiscard]] static Result<PagedVolume> create(const FusionConfig& config, const std::filesystem::path& folder);

  /// As scanknit::integrate(). Errors also: kBudget when a frame alone changes almost as much as the memory has room
  /// for, or when pages are read and written so often that reading the frames twice would cost less; kOutput for a page
  /// that cannot be written or read. The volume is of no use after these.
  [[nodiscard]] Result<IntegrateStats> integrate(const Frame& frame, const Pose& T_world_camera);

  /// Writes what is in memory, and gives the whole volume, which is in `folder`. Errors: as above. Call it once, last.
  [[nodiscard]] Result<BrickVolume> finish();

 private:
  struct Page {
    BlocksOfRegion blocks;      ///< of the file
    BlocksOfRegion to_carve;    ///< those of them that are not known to be free
    bool is_in_memory = false;  ///< too, perhaps changed
  };
  PagedVolume(TsdfVolume volume, std::filesystem::path folder)
      : volume_(std::move(volume)), folder_(std::move(folder)) {}

  [[nodiscard]] Result<void> make_room(std::span<const BandBlock> band, const SpaceInFront* front);
  /// Memory with these blocks and pages, if each block had colours.
  [[nodiscard]] std::size_t bytes_with(std::span<const BandBlock> band, std::span<const openvdb::Coord> pages) const;
  [[nodiscard]] Result<void> page_in(const openvdb::Coord& region);
  /// All regions but these.
  [[nodiscard]] Result<void> page_out(const RegionSet& kept);
  [[nodiscard]] std::filesystem::path path_of(const openvdb::Coord& region) const;

  TsdfVolume volume_;
  std::filesystem::path folder_;
  std::map<openvdb::Coord, Page> pages_;
  std::uint32_t full_since_ = 0;  ///< the frame at which the memory was full for the first time; 0: never
  std::size_t read_again_ = 0;    ///< blocks of pages
  std::size_t tight_ = 0;         ///< frames that filled almost all of the memory
};

}  // namespace scanknit
