// Range scans from files: Stanford range grids (PLY), organised PCD, PTX, and lists of scans with poses (.conf).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/limits.h"
#include "core/range_scan.h"
#include "core/result.h"

namespace scanknit {

/// Points without a grid.
struct PointCloud {
  std::string name;
  std::vector<Eigen::Vector3f> points_m;
  std::vector<Eigen::Vector3f> normals;  ///< unit, or zero where unknown; empty, or one a point
  std::vector<Rgb8> colours;             ///< empty, or one a point
};

/// The content of one file. A PTX may have several scans.
struct RangeFile {
  std::vector<RangeScan> scans;
  std::vector<PointCloud> clouds;
};

/// Stanford PLY with a `range_grid` element, ASCII or binary, row 0 at the bottom. The scanner stands at larger z; its
/// lines of sight are estimated from the grid. A vertex that is not finite is no return. Errors (kInput): not one,
/// counts beyond the limits or the file, an index out of range, truncated. A pure function of the bytes, like those
/// below.
[[nodiscard]] Result<RangeScan> parse_range_ply(std::string_view bytes, const Limits& limits);

/// True for the PLY whose header has a `range_grid` element.
[[nodiscard]] bool is_range_ply(std::string_view bytes);

/// PTX: for each scan columns, rows, the scanner's position and axes, a 4x4 matrix (row vectors), and a point a line,
/// column by column from the bottom: x y z [intensity [r g b]]. 0 0 0, or a number that is not finite, is no return.
[[nodiscard]] Result<std::vector<RangeScan>> parse_ptx(std::string_view bytes, const Limits& limits);

/// A PCD: a scan where it is organised (HEIGHT above 1), else a cloud. VIEWPOINT is the pose of the scan.
[[nodiscard]] Result<RangeFile> parse_pcd_range(std::string_view bytes, const Limits& limits);

/// Unpacks gzip; bytes that are not packed are returned as they are. Errors (kInput): damaged, or more than the limit;
/// kBudget: more than fits into memory.
[[nodiscard]] Result<std::string> unpack_gzip(std::string bytes, std::uintmax_t max_bytes);

/// One scan of a .conf.
struct NamedScan {
  std::string file;  ///< as the .conf names it
  Pose T_world_scan;
  std::size_t line;
};

/// Stanford's .conf: `bmesh FILE tx ty tz qx qy qz qw`, where x_world = R(q)^T x + t; lines of `camera` are passed
/// over. Errors (kInput): an unknown line, a number that is none, a quaternion whose length is not 1, no scan at all.
[[nodiscard]] Result<std::vector<NamedScan>> parse_conf(std::string_view text, const Limits& limits);

/// Reads .ply, .ply.gz, .pcd, .ptx, each packed with gzip or not; the content decides between a scan and a cloud. A PLY
/// without a grid is no range file: nothing is returned, and a mesh reader may have it. Errors (kInput), with the path;
/// kBudget: it does not fit into memory.
[[nodiscard]] Result<RangeFile> read_range_file(const std::filesystem::path& path, const Limits& limits = {});

/// True for a name that read_range_file() may take.
[[nodiscard]] bool is_range_path(const std::filesystem::path& path);

}  // namespace scanknit
