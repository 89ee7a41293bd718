#include <fmt/format.h>

#include <iterator>

#include "core/version.h"
#include "export/mesh/byte_writer.h"
#include "export/mesh/mesh_writers.h"

namespace scanknit {
namespace {

/// One line at a time; "{}" prints the fewest digits that give the same float back.
class LineWriter {
 public:
  explicit LineWriter(AtomicFile& file) : out_(file) {}

  template <typename... Values>
  void line(fmt::format_string<Values...> format, Values&&... values) {
    line_.clear();
    fmt::format_to(std::back_inserter(line_), format, std::forward<Values>(values)...);
    line_.push_back('\n');
    out_.text({line_.data(), line_.size()});
  }
  [[nodiscard]] Result<void> finish() { return out_.finish(); }

 private:
  ByteWriter out_;
  fmt::memory_buffer line_;
};

void write_vertices(const Mesh& mesh, const Placement& placement, LineWriter& out) {
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const Eigen::Vector3f p = placement.position(mesh.positions_m[i]);
    if (mesh.colours.empty()) {
      out.line("v {} {} {}", p.x(), p.y(), p.z());
    } else {
      const Rgb8 c = mesh.colours[i];  // 1/255 steps need four digits to come back exactly
      out.line("v {} {} {} {:.4f} {:.4f} {:.4f}", p.x(), p.y(), p.z(), c.r / 255.0, c.g / 255.0, c.b / 255.0);
    }
  }
}

}  // namespace

Result<void> write_obj(const Mesh& mesh, const Placement& placement, AtomicFile& file) {
  LineWriter out(file);
  out.line("# ScanKnit {}", kVersion);
  out.line("# positions in {}{}", placement.unit, mesh.colours.empty() ? "" : "; v x y z r g b, colours sRGB");
  write_vertices(mesh, placement, out);
  for (const Eigen::Vector3f& normal : mesh.normals) {
    const Eigen::Vector3f n = placement.normal(normal);
    out.line("vn {} {} {}", n.x(), n.y(), n.z());
  }
  for (const Triangle& t : mesh.triangles) {  // OBJ counts from 1
    const std::uint64_t a = t[0] + 1ull, b = t[1] + 1ull, c = t[2] + 1ull;
    if (mesh.normals.empty()) {
      out.line("f {} {} {}", a, b, c);
    } else {
      out.line("f {0}//{0} {1}//{1} {2}//{2}", a, b, c);
    }
  }
  return out.finish();
}

}  // namespace scanknit
