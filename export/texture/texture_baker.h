// TextureBaker: computes the colours of an atlas's texels from the frames of a scan, one by one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frame.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "export/picture/surface_fit.h"
#include "export/texture/posed_picture.h"
#include "export/texture/texture_atlas.h"

namespace scanknit {

struct BakedTexture {
  ColourImage image;       ///< sRGB; pixels without a triangle have the colour of the nearest texel
  std::size_t texels = 0;  ///< texels that a triangle covers
  double seen_share = 0;   ///< share of those that a frame saw
  std::size_t frames = 0;  ///< frames that were added
};

/// Keeps the few best sights of each texel. The mesh is in metres.
class TextureBaker {
 public:
  /// Both outlive it.
  TextureBaker(const Mesh& mesh, const TextureAtlas& atlas, const FitBand& band);

  /// The memory for the sights of the atlas's texels.
  [[nodiscard]] static std::uint64_t memory_bytes(const TextureAtlas& atlas);

  /// Adds a frame with colour. Adapts its exposure to the mesh's colours. The same bits for any number of threads; the
  /// order of frames matters only for equally good sights.
  void add(const Frame& frame, const Pose& T_world_camera);

  /// Mixes the best sights in linear light. Texels without any sight get the colours of the mesh, or, if it has none,
  /// the colour of the nearest texel.
  [[nodiscard]] BakedTexture bake() const;

 private:
  static constexpr std::size_t kSights = 4;
  struct Sights {
    std::array<float, kSights> quality{};                        ///< best first; 0: none
    std::array<std::array<std::uint16_t, 3>, kSights> colour{};  ///< linear, of 65535
  };
  /// A vertex in the colour camera's frame.
  struct SeenVertex {
    Eigen::Vector3f p, normal;
    unsigned out_of_sight;
  };

  void project(const PosedPicture& view);
  [[nodiscard]] LinearColour gain_of(const PosedPicture& view) const;
  void look_at(std::size_t triangle, const PosedPicture& view, const LinearColour& gain);
  [[nodiscard]] LinearColour mesh_colour(std::size_t triangle, const std::array<float, 3>& weights) const;
  [[nodiscard]] LinearColour mixed(const Sights& sights, const LinearColour& otherwise) const;

  const Mesh& mesh_;
  const TextureAtlas& atlas_;
  FitBand band_;
  std::vector<std::size_t> first_texel_;  ///< of each triangle in `sights_`, and the end
  std::vector<Sights> sights_;
  std::vector<Eigen::Vector3f> normals_;  ///< of the mesh; need not be unit
  std::vector<SeenVertex> seen_;          ///< of the mesh's vertices, for the current frame
  std::size_t frames_ = 0;
};

}  // namespace scanknit
