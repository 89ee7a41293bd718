// TextureBaker: colours for the texels of an atlas, from the frames of a scan, one frame after another.
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
  ColourImage image;       ///< sRGB; what no triangle covers has the colour of the nearest texel
  std::size_t texels = 0;  ///< that a triangle covers
  double seen_share = 0;   ///< of those, that some frame saw
  std::size_t frames = 0;  ///< that were added
};

/// Keeps for each texel the few best sights of it. The mesh is in metres.
class TextureBaker {
 public:
  /// Both outlive it.
  TextureBaker(const Mesh& mesh, const TextureAtlas& atlas, const FitBand& band);

  /// Memory for the sights of so many texels.
  [[nodiscard]] static std::uint64_t memory_bytes(const TextureAtlas& atlas);

  /// A frame with colour. Its exposure is brought to that of the mesh's colours. The same bits for any number of
  /// threads; the order of frames matters only where sights are equally good.
  void add(const Frame& frame, const Pose& T_world_camera);

  /// The best sights mixed in linear light; where there are none, the colours of the mesh. A mesh
  /// without colours has the colour of the nearest texel there.
  [[nodiscard]] BakedTexture bake() const;

 private:
  static constexpr std::size_t kSights = 4;
  struct Sights {
    std::array<float, kSights> quality{};                        ///< best first; 0: none
    std::array<std::array<std::uint16_t, 3>, kSights> colour{};  ///< linear, of 65535
  };
  /// A vertex before the colour camera.
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
  std::vector<SeenVertex> seen_;          ///< of the mesh's vertices, by the frame at hand
  std::size_t frames_ = 0;
};

}  // namespace scanknit
