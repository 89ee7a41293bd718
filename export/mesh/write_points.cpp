#include "export/mesh/write_points.h"

#include <fmt/format.h>

#include "core/files/atomic_file.h"
#include "core/version.h"
#include "export/mesh/byte_writer.h"

namespace scanknit {
namespace {

std::string ply_points_head(const Mesh& points) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment ScanKnit {}\ncomment positions in metres{}\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
      kVersion, points.colours.empty() ? "" : ", colours sRGB", points.positions_m.size());
  if (!points.normals.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!points.colours.empty()) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  return text + "end_header\n";
}

std::string pcd_head(const Mesh& points) {
  std::string fields = "x y z", sizes = "4 4 4", types = "F F F", counts = "1 1 1";
  if (!points.normals.empty()) {
    fields += " normal_x normal_y normal_z";
    sizes += " 4 4 4";
    types += " F F F";
    counts += " 1 1 1";
  }
  if (!points.colours.empty()) {
    fields += " rgb";
    sizes += " 4";
    types += " U";
    counts += " 1";
  }
  return fmt::format(
      "# .PCD v0.7 - ScanKnit {}\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\nWIDTH {}\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      kVersion, fields, sizes, types, counts, points.positions_m.size(), points.positions_m.size());
}

}  // namespace

bool is_points_path(const std::filesystem::path& path) {
  return path.extension() == ".ply" || path.extension() == ".pcd";
}

Result<void> write_points(const Mesh& points, const std::filesystem::path& path) {
  const auto failure = [&](const char* what) { return Error{ErrorCode::kOutput, what, path.string()}; };
  if (!is_points_path(path)) return failure("points are written as .ply or .pcd");
  if (points.positions_m.empty()) return failure("there is no point to write");
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  const bool is_pcd = path.extension() == ".pcd";
  ByteWriter out(*file);
  out.text(is_pcd ? pcd_head(points) : ply_points_head(points));
  for (std::size_t i = 0; i < points.positions_m.size(); ++i) {
    out.put(points.positions_m[i]);
    if (!points.normals.empty()) out.put(points.normals[i]);
    if (points.colours.empty()) continue;
    const Rgb8 c = points.colours[i];
    if (is_pcd) {
      out.put(static_cast<std::uint32_t>(c.r) << 16 | static_cast<std::uint32_t>(c.g) << 8 | c.b);
    } else {
      out.put(c.r);
      out.put(c.g);
      out.put(c.b);
    }
  }
  if (auto written = out.finish(); !written) return written;
  return file->commit();
}

}  // namespace scanknit
