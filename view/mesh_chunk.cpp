#include "view/mesh_chunk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "core/check.h"

namespace scanknit {
namespace {

static_assert(std::endian::native == std::endian::little, "the protocol is little endian");

constexpr std::uint32_t kChunk = 1, kGone = 2, kPicture = 3;
constexpr std::uint32_t kHasColours = 1, kHasWideIndices = 2;
constexpr float kSteps = 65534;  // one less than 16 bits hold: a chunk begins at the step below its first vertex
constexpr Rgb8 kGrey{188, 188, 188};

/// A vertex as it is sent.
struct PackedVertex {
  std::uint16_t q[3];
  std::uint16_t uncertainty_um;
  std::uint8_t colour[3];
  std::uint8_t coverage;
  std::int8_t normal[3];
  std::int8_t zero_normal;
};
static_assert(sizeof(PackedVertex) == 16);

template <typename T>
void append(std::string& message, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  message.append(bytes, sizeof(T));
}

void append_header(std::string& message, std::uint32_t kind, std::uint32_t chunk, std::uint32_t revision) {
  message += "SKM1";
  append(message, kind);
  append(message, chunk);
  append(message, revision);
}

/// The origin and the step of a chunk's coordinates.
struct Lattice {
  std::array<std::int64_t, 3> first{};  ///< the origin, in steps from the world's origin
  float step_m = 1;
};

Lattice lattice_of(std::span<const ChunkPart> parts, float finest_m) {
  Eigen::AlignedBox3f box;
  for (const ChunkPart& part : parts) {
    for (const Eigen::Vector3f& position : part.mesh->positions_m) box.extend(position);
  }
  if (box.isEmpty()) return {};
  Lattice lattice;
  lattice.step_m = std::max(step_for(box.sizes().maxCoeff()), finest_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double least = box.min()[static_cast<Eigen::Index>(axis)];
    lattice.first[axis] = static_cast<std::int64_t>(std::floor(least / lattice.step_m));
  }
  return lattice;
}

std::uint16_t quantised(float position_m, const Lattice& lattice, std::size_t axis) {
  const std::int64_t steps = std::llrint(static_cast<double>(position_m) / lattice.step_m) - lattice.first[axis];
  return static_cast<std::uint16_t>(std::clamp<std::int64_t>(steps, 0, 65535));
}

/// 0: unknown; at most what 16 bits hold, 65 mm.
std::uint16_t micrometres(float uncertainty_m) {
  if (!(uncertainty_m > 0)) return 0;
  return static_cast<std::uint16_t>(std::clamp(std::ceil(uncertainty_m * 1e6f), 1.0f, 65535.0f));
}

PackedVertex packed(const ChunkPart& part, std::size_t i, const Lattice& lattice) {
  const Mesh& mesh = *part.mesh;
  const Rgb8 colour = mesh.colours.empty() ? kGrey : mesh.colours[i];
  PackedVertex vertex{};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    vertex.q[axis] = quantised(mesh.positions_m[i][axis], lattice, static_cast<std::size_t>(axis));
    if (mesh.normals.empty()) continue;
    const float component = std::fmin(std::fmax(mesh.normals[i][axis], -1.0f), 1.0f);
    vertex.normal[axis] = static_cast<std::int8_t>(std::lrint(component * 127));
  }
  vertex.colour[0] = colour.r;
  vertex.colour[1] = colour.g;
  vertex.colour[2] = colour.b;
  vertex.coverage = part.coverage.empty() ? std::uint8_t{255} : part.coverage[i];
  if (!part.uncertainty_m.empty()) vertex.uncertainty_um = micrometres(part.uncertainty_m[i]);
  return vertex;
}

template <typename Index>
void append_indices(std::string& message, std::span<const ChunkPart> parts) {
  std::uint32_t first = 0;
  for (const ChunkPart& part : parts) {
    for (const Triangle& triangle : part.mesh->triangles) {
      for (const std::uint32_t index : triangle) append(message, static_cast<Index>(first + index));
    }
    first += static_cast<std::uint32_t>(part.mesh->positions_m.size());
  }
}

}  // namespace

float step_for(float extent_m) {
  constexpr float kFinest = 1e-9f;
  return std::exp2(std::ceil(std::log2(std::max(extent_m / kSteps, kFinest))));
}

std::string chunk_message(std::uint32_t chunk, std::uint32_t revision, std::span<const ChunkPart> parts,
                          float finest_m) {
  std::size_t vertices = 0;
  std::size_t indices = 0;
  bool has_colours = false;
  for (const ChunkPart& part : parts) {
    const std::size_t count = part.mesh->positions_m.size();
    SCANKNIT_CHECK(part.coverage.empty() || part.coverage.size() == count);
    SCANKNIT_CHECK(part.uncertainty_m.empty() || part.uncertainty_m.size() == count);
    vertices += count;
    indices += 3 * part.mesh->triangles.size();
    has_colours = has_colours || !part.mesh->colours.empty();
  }
  constexpr std::size_t kMostNarrow = 65535;  // index 65535 begins a new strip in WebGL 2
  const bool is_wide = vertices > kMostNarrow;
  const Lattice lattice = lattice_of(parts, finest_m);

  std::string message;
  message.reserve(48 + sizeof(PackedVertex) * vertices + (is_wide ? 4 : 2) * indices);
  append_header(message, kChunk, chunk, revision);
  append(message, static_cast<std::uint32_t>(vertices));
  append(message, static_cast<std::uint32_t>(indices));
  append(message, (has_colours ? kHasColours : 0u) | (is_wide ? kHasWideIndices : 0u));
  append(message, std::uint32_t{0});
  for (const std::int64_t first : lattice.first)
    append(message, static_cast<float>(static_cast<double>(first) * lattice.step_m));
  append(message, lattice.step_m);
  for (const ChunkPart& part : parts) {
    for (std::size_t i = 0; i < part.mesh->positions_m.size(); ++i) append(message, packed(part, i, lattice));
  }
  if (is_wide) {
    append_indices<std::uint32_t>(message, parts);
  } else {
    append_indices<std::uint16_t>(message, parts);
  }
  return message;
}

std::string chunk_gone_message(std::uint32_t chunk, std::uint32_t revision) {
  std::string message;
  append_header(message, kGone, chunk, revision);
  return message;
}

std::string picture_message(std::uint32_t revision, std::span<const std::uint8_t> jpeg) {
  std::string message;
  message.reserve(16 + jpeg.size());
  append_header(message, kPicture, 0, revision);
  for (const std::uint8_t byte : jpeg) message.push_back(static_cast<char>(byte));
  return message;
}

}  // namespace scanknit
