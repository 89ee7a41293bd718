#include "export/glb/glb_arrays.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/check.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

constexpr int kByte = 5120, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;  // glTF 2.0, 3.6.2.2
constexpr double kShortEnd = 65535, kByteEnd = 127;
constexpr std::uint16_t kOpaque = 65535;

std::uint16_t share_of_65535(double share) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * kShortEnd));
}

/// The arrays of one primitive.
class PartArrays {
 public:
  PartArrays(const GlbContents& contents, const GlbPart& part, const QuantizationGrid* grid, GlbBytes bytes)
      : contents_(contents), part_(part), grid_(grid), bytes_(bytes), count_(part.vertices.size()) {}

  [[nodiscard]] GlbArray positions() const {
    Eigen::Vector3f low = position(0), high = low;
    for (std::size_t i = 0; i < count_; ++i) {
      const Eigen::Vector3f p = position(i);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if (grid_ == nullptr) {
      GlbArray array{"POSITION", "VEC3", kFloat, false, sizeof(Eigen::Vector3f), count_};
      array.lowest = {low.x(), low.y(), low.z()};  // glTF 2.0, 3.6.2.5: they must equal the stored floats
      array.highest = {high.x(), high.y(), high.z()};
      return filled(std::move(array), [this](std::size_t i) { return floats(position(i)); });
    }
    GlbArray array{"POSITION", "VEC3", kUnsignedShort, true, 8, count_};
    const auto first = on_grid(low), last = on_grid(high);
    array.lowest = {first.begin(), first.begin() + 3};
    array.highest = {last.begin(), last.begin() + 3};
    return filled(std::move(array), [this](std::size_t i) { return on_grid(position(i)); });
  }

  [[nodiscard]] GlbArray normals() const {
    if (grid_ == nullptr) {
      return filled({"NORMAL", "VEC3", kFloat, false, sizeof(Eigen::Vector3f), count_},
                    [this](std::size_t i) { return floats(normal(i).cast<float>()); });
    }
    return filled({"NORMAL", "VEC3", kByte, true, 4, count_}, [this](std::size_t i) {
      const Eigen::Vector3d n = normal(i) * kByteEnd;
      const auto rounded = [](double v) { return static_cast<std::int8_t>(std::lround(v)); };
      return std::array{rounded(n.x()), rounded(n.y()), rounded(n.z()), std::int8_t{0}};
    });
  }

  /// Linear, 16 bits, four channels: glTF's COLOR_0 is linear; eight bits would band in the darks; three channels of 16
  /// bits would break the 4-byte alignment.
  [[nodiscard]] GlbArray colours() const {
    std::array<std::uint16_t, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
      linear[i] = share_of_65535(linear_from_srgb(static_cast<std::uint8_t>(i)));
    }
    return filled({"COLOR_0", "VEC4", kUnsignedShort, true, 8, count_}, [&](std::size_t i) {
      const Rgb8 c = contents_.mesh.colours[part_.vertices[i]];
      return std::array{linear[c.r], linear[c.g], linear[c.b], kOpaque};
    });
  }

  [[nodiscard]] GlbArray coordinates() const {
    const auto uv = [this](std::size_t i) { return contents_.texture->coordinates[part_.vertices[i]]; };
    if (grid_ == nullptr) {
      return filled({"TEXCOORD_0", "VEC2", kFloat, false, sizeof(Eigen::Vector2f), count_}, [&](std::size_t i) {
        return std::array{uv(i).x(), uv(i).y()};
      });
    }
    return filled({"TEXCOORD_0", "VEC2", kUnsignedShort, true, 4, count_}, [&](std::size_t i) {
      return std::array{share_of_65535(uv(i).x()), share_of_65535(uv(i).y())};
    });
  }

  [[nodiscard]] GlbArray indices() const {
    GlbArray array{"", "SCALAR", kUnsignedInt, false, sizeof(std::uint32_t), 3 * part_.triangles.size()};
    static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
    const auto bytes = std::as_bytes(part_.triangles);
    if (bytes_ == GlbBytes::kMade) array.bytes = {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()};
    return array;
  }

 private:
  /// Fills the array with `element(i)`, a std::array of array.stride bytes, for each i below array.count.
  template <typename Element>
  [[nodiscard]] GlbArray filled(GlbArray array, const Element& element) const {
    using Values = decltype(element(0));
    SCANKNIT_CHECK(array.stride == sizeof(Values));
    if (bytes_ == GlbBytes::kLeftOut) return array;
    array.own_bytes.resize(array.byte_length());
    for (std::size_t i = 0; i < array.count; ++i) {
      const Values values = element(i);
      std::memcpy(array.own_bytes.data() + i * sizeof(Values), values.data(), sizeof(Values));
    }
    array.bytes = array.own_bytes;
    return array;
  }

  [[nodiscard]] static std::array<float, 3> floats(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

  [[nodiscard]] Eigen::Vector3f position(std::size_t i) const {
    return contents_.placement.position(contents_.mesh.positions_m[part_.vertices[i]]);
  }

  /// Of unit length; +Y where the direction is unknown.
  [[nodiscard]] Eigen::Vector3d normal(std::size_t i) const {
    const Eigen::Vector3d n = contents_.placement.normal(contents_.mesh.normals[part_.vertices[i]]).cast<double>();
    return n.norm() > 0 ? n.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitY());
  }

  [[nodiscard]] std::array<std::uint16_t, 4> on_grid(const Eigen::Vector3f& p) const {
    std::array<std::uint16_t, 4> stored{};  // the fourth fills the stride
    for (int axis = 0; axis < 3; ++axis) {
      const double share = (static_cast<double>(p[axis]) - grid_->origin_m[axis]) / grid_->side_m;
      stored[static_cast<std::size_t>(axis)] = share_of_65535(share);
    }
    return stored;
  }

  const GlbContents& contents_;
  const GlbPart& part_;
  const QuantizationGrid* grid_;
  GlbBytes bytes_;
  std::size_t count_;
};

}  // namespace

QuantizationGrid quantization_grid(const Mesh& mesh, const Placement& placement) {
  Eigen::Vector3f low = placement.position(mesh.positions_m.front()), high = low;
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    low = low.cwiseMin(placement.position(p));
    high = high.cwiseMax(placement.position(p));
  }
  const float side_m = (high - low).maxCoeff();
  return {low, side_m > 0 ? side_m : 1};
}

void for_each_array(const GlbContents& contents, const GlbPart& part, const QuantizationGrid* grid, GlbBytes bytes,
                    const std::function<void(const GlbArray&)>& take) {
  const PartArrays arrays(contents, part, grid, bytes);
  take(arrays.positions());
  if (!contents.mesh.normals.empty()) take(arrays.normals());
  if (!contents.mesh.colours.empty()) take(arrays.colours());
  if (contents.texture != nullptr) take(arrays.coordinates());
  take(arrays.indices());
}

std::size_t bytes_of_a_vertex(const GlbContents& contents, bool is_quantized) {
  std::size_t bytes = is_quantized ? 8 : 12;
  if (!contents.mesh.normals.empty()) bytes += is_quantized ? 4 : 12;
  if (!contents.mesh.colours.empty()) bytes += 8;
  if (contents.texture != nullptr) bytes += is_quantized ? 4 : 8;
  return bytes;
}

}  // namespace scanknit
