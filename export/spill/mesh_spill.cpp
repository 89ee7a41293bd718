#include "export/spill/mesh_spill.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "export/mesh/byte_writer.h"
#include "export/mesh/mesh_writers.h"
#include "export/placement_plan.h"
#include "export/spill/vertex_clusters.h"

namespace scanknit {
namespace {

constexpr std::size_t kChunk = 1u << 14;  // vertices or triangles read at a time

const Eigen::Vector3f kNoNormal = Eigen::Vector3f::Zero();

/// A vertex as it is spilled; the second vector only where there are normals.
using Spilled = std::array<Eigen::Vector3f, 2>;

constexpr std::size_t vertex_bytes(bool has_normals) {
  return sizeof(Eigen::Vector3f) * (has_normals ? 2 : 1);
}

/// Calls `take` with every T of `file`, in order, until it fails.
template <typename T, typename Take>
Result<void> for_each(const SpillFile& file, std::size_t bytes_each, const Take& take) {
  std::vector<std::byte> bytes(kChunk * bytes_each);
  for (std::uint64_t offset = 0; offset < file.size(); offset += bytes.size()) {
    bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), file.size() - offset)));
    if (auto read = file.read(offset, bytes); !read) return read;
    for (std::size_t at = 0; at < bytes.size(); at += bytes_each) {
      T value;
      std::memcpy(static_cast<void*>(&value), bytes.data() + at, bytes_each);
      if (auto taken = take(value); !taken) return taken;
    }
  }
  return {};
}

/// Positions by index. Triangles name vertices that were spilled shortly before or after each other, so that a few
/// chunks in memory nearly always hold what is asked for.
class PositionCache {
 public:
  PositionCache(const SpillFile& file, std::size_t bytes_each) : file_(file), bytes_each_(bytes_each), slots_(kSlots) {}

  [[nodiscard]] Result<Eigen::Vector3f> position(std::size_t vertex) {
    const std::size_t chunk = vertex / kChunk;
    Slot& slot = slots_[chunk % kSlots];
    if (slot.bytes.empty() || slot.chunk != chunk) {
      if (auto read = load(chunk, slot); !read) return read.error();
    }
    Eigen::Vector3f position;
    std::memcpy(position.data(), slot.bytes.data() + vertex % kChunk * bytes_each_, sizeof(position));
    return position;
  }

 private:
  static constexpr std::size_t kSlots = 32;
  struct Slot {
    std::size_t chunk = 0;
    std::vector<std::byte> bytes;
  };

  Result<void> load(std::size_t chunk, Slot& slot) const {
    const std::uint64_t offset = std::uint64_t{chunk} * kChunk * bytes_each_;
    slot.chunk = chunk;
    slot.bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kChunk * bytes_each_, file_.size() - offset)));
    return file_.read(offset, slot.bytes);
  }

  const SpillFile& file_;
  std::size_t bytes_each_;
  std::vector<Slot> slots_;
};

Error not_finite(const char* what) {
  return {ErrorCode::kMesh, std::string(what) + " of a vertex is not finite"};
}

Error beyond(std::size_t vertices) {
  return {ErrorCode::kMesh, "a triangle names a vertex beyond the " + std::to_string(vertices) + " there are"};
}

bool names_vertices_below(std::size_t vertices, const Triangle& triangle) {
  return *std::max_element(triangle.begin(), triangle.end()) < vertices;
}

Result<std::array<Eigen::Vector3f, 3>> corners_of(const Triangle& triangle, std::size_t vertices,
                                                  PositionCache& positions) {
  if (!names_vertices_below(vertices, triangle)) return beyond(vertices);
  std::array<Eigen::Vector3f, 3> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto position = positions.position(triangle[i]);
    if (!position) return position.error();
    corners[i] = *position;
  }
  return corners;
}

}  // namespace

Result<MeshSpill> MeshSpill::create(const std::filesystem::path& folder) {
  auto vertex_file = SpillFile::create(folder);
  if (!vertex_file) return vertex_file.error();
  auto triangle_file = SpillFile::create(folder);
  if (!triangle_file) return triangle_file.error();
  return MeshSpill(std::move(*vertex_file), std::move(*triangle_file));
}

MeshSpill::MeshSpill(SpillFile vertex_file, SpillFile triangle_file)
    : vertex_file_(std::move(vertex_file)), triangle_file_(std::move(triangle_file)) {}

Result<void> MeshSpill::add(const Mesh& part) {
  SCANKNIT_CHECK(part.normals.empty() || part.normals.size() == part.positions_m.size());
  if (vertices_ == 0) has_normals_ = !part.normals.empty();
  SCANKNIT_CHECK(part.positions_m.empty() || has_normals_ == !part.normals.empty());
  std::vector<Eigen::Vector3f> vectors;
  vectors.reserve(part.positions_m.size() * (has_normals_ ? 2 : 1));
  for (std::size_t i = 0; i < part.positions_m.size(); ++i) {
    if (!part.positions_m[i].allFinite()) return not_finite("the position");
    bounds_.extend(part.positions_m[i]);
    vectors.push_back(part.positions_m[i]);
    if (!has_normals_) continue;
    if (!part.normals[i].allFinite()) return not_finite("the normal");
    vectors.push_back(part.normals[i]);
  }
  if (auto spilled = vertex_file_.append(std::as_bytes(std::span(vectors))); !spilled) return spilled;
  vertices_ += part.positions_m.size();
  triangles_ += part.triangles.size();
  return triangle_file_.append(std::as_bytes(std::span(part.triangles)));
}

namespace {

struct SpilledMesh {
  const SpillFile &vertex_file, &triangle_file;
  std::size_t vertices, triangles;
  bool has_normals;
};

Result<void> write_ply(const SpilledMesh& mesh, const Placement& placement, ByteWriter& out) {
  out.text(ply_head({mesh.vertices, mesh.triangles, mesh.has_normals, false}, placement));
  const auto put_vertex = [&](const Spilled& vertex) -> Result<void> {
    const Eigen::Vector3f position = placement.position(vertex[0]);
    if (!position.allFinite()) return not_finite("the position");
    out.put(position);
    if (mesh.has_normals) out.put(placement.normal(vertex[1]));
    return {};
  };
  if (auto put = for_each<Spilled>(mesh.vertex_file, vertex_bytes(mesh.has_normals), put_vertex); !put) return put;
  return for_each<Triangle>(mesh.triangle_file, sizeof(Triangle), [&](const Triangle& triangle) -> Result<void> {
    if (!names_vertices_below(mesh.vertices, triangle)) return beyond(mesh.vertices);
    put_ply_face(triangle, out);
    return {};
  });
}

Result<void> write_stl(const SpilledMesh& mesh, const Placement& placement, ByteWriter& out) {
  out.text(stl_head(placement));
  out.put(static_cast<std::uint32_t>(mesh.triangles));
  PositionCache positions(mesh.vertex_file, vertex_bytes(mesh.has_normals));
  return for_each<Triangle>(mesh.triangle_file, sizeof(Triangle), [&](const Triangle& triangle) -> Result<void> {
    auto corners = corners_of(triangle, mesh.vertices, positions);
    if (!corners) return corners.error();
    for (Eigen::Vector3f& corner : *corners) {
      corner = placement.position(corner);
      if (!corner.allFinite()) return not_finite("the position");
    }
    put_stl_facet(*corners, out);
    return {};
  });
}

}  // namespace

Result<WrittenFile> MeshSpill::write(const std::filesystem::path& path, const ExportConfig& config, UpAxis world_up,
                                     std::optional<double> file_unit_m) const {
  if (!can_be_written_in_parts(path)) {
    return Error{ErrorCode::kBudget, "a mesh that is written part by part must be .ply or .stl", path.string()};
  }
  if (triangles_ == 0) return Error{ErrorCode::kMesh, "the mesh is empty", path.string()};
  if (auto fits = check_counts(vertices_, triangles_); !fits) return located(fits.error(), path);
  const PlacementPlan plan = plan_placement(*mesh_format(path), config, world_up, file_unit_m);
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  ByteWriter out(*file);
  const SpilledMesh mesh{vertex_file_, triangle_file_, vertices_, triangles_, has_normals_};
  const Result<void> put =
      plan.format == MeshFormat::kPly ? write_ply(mesh, plan.placement, out) : write_stl(mesh, plan.placement, out);
  if (!put) return located(put.error(), path);
  if (auto finished = out.finish(); !finished) return finished.error();
  if (auto committed = file->commit(); !committed) return committed.error();
  return written_file(path, plan);
}

Result<Mesh> MeshSpill::coarse(std::size_t most_vertices) const {
  constexpr int kFinest = 256;  // cubes along the longest side: more than a picture shows
  if (triangles_ == 0) return Error{ErrorCode::kMesh, "the mesh is empty"};
  for (int cubes = kFinest;; cubes /= 2) {
    VertexClusters clusters(bounds_, cubes);
    auto added =
        for_each<Spilled>(vertex_file_, vertex_bytes(has_normals_), [&](const Spilled& vertex) -> Result<void> {
          if (clusters.size() <= most_vertices) clusters.add_vertex(vertex[0], has_normals_ ? vertex[1] : kNoNormal);
          return {};
        });
    if (!added) return added.error();
    if (clusters.size() > most_vertices && cubes > 1) continue;
    PositionCache positions(vertex_file_, vertex_bytes(has_normals_));
    added = for_each<Triangle>(triangle_file_, sizeof(Triangle), [&](const Triangle& triangle) -> Result<void> {
      const auto corners = corners_of(triangle, vertices_, positions);
      if (!corners) return corners.error();
      clusters.add_triangle(*corners);
      return {};
    });
    if (!added) return added.error();
    return clusters.take();
  }
}

bool can_be_written_in_parts(const std::filesystem::path& path) {
  const auto format = mesh_format(path);
  return format == MeshFormat::kPly || format == MeshFormat::kStl;
}

}  // namespace scanknit
