#include "export/texture/texture_baker.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/mesh_area.h"
#include "export/texture/srgb.h"
#include "export/texture/texture_fill.h"

namespace scanknit {
namespace {

constexpr float kFull = 65535;
constexpr float kShareOfWorst = 0.95f;  // of the worst sight's weight is taken from all: the one that leaves had little
constexpr float kMeshWeight = 0.003f;   // pixels to a texel; of the mesh's own colour, so that sights fade into it
constexpr std::size_t kGrain = 1024;

// Exposure: compared at some vertices, where neither picture nor mesh is too dark or clipped.
constexpr std::size_t kCompared = 20'000;
constexpr std::size_t kLeastCompared = 200;
constexpr float kDarkest = 0.01f, kBrightest = 0.9f;
constexpr float kMostGain = 2;

template <typename Work>
void for_each_index(std::size_t count, Work&& work) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
  });
}

float linear(std::uint8_t encoded) {
  return static_cast<float>(linear_from_srgb(encoded));
}

std::uint16_t stored(float value) {
  return static_cast<std::uint16_t>(std::clamp(value, 0.0f, 1.0f) * kFull + 0.5f);
}

/// Of each vertex, by the area of its triangles; not unit.
std::vector<Eigen::Vector3f> mean_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.positions_m.size(), Eigen::Vector3f::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3f n = area_vector_m2(mesh, t).cast<float>();
    for (const std::uint32_t v : t) normals[v] += n;
  }
  return normals;
}

}  // namespace

TextureBaker::TextureBaker(const Mesh& mesh, const TextureAtlas& atlas, const FitBand& band)
    : mesh_(mesh), atlas_(atlas), band_(band), normals_(mesh.normals), seen_(mesh.positions_m.size()) {
  if (normals_.empty()) normals_ = mean_normals(mesh);
  const std::size_t n = atlas.triangles.size();
  first_texel_.assign(n + 1, 0);
  for_each_index(n, [&](std::size_t t) {
    for_each_texel(atlas.corners(t), [&](int, int, const auto&) { return ++first_texel_[t + 1], true; });
  });
  for (std::size_t t = 0; t < n; ++t) first_texel_[t + 1] += first_texel_[t];
  sights_.resize(first_texel_[n]);
}

std::uint64_t TextureBaker::memory_bytes(const TextureAtlas& atlas) {
  const std::uint64_t texels = static_cast<std::uint64_t>(atlas.width) * static_cast<std::uint64_t>(atlas.height);
  return texels * (sizeof(Sights) + 16);  // and the picture with its filling
}

void TextureBaker::project(const PosedPicture& view) {
  const Eigen::Isometry3f T = view.T_colour_world().cast<float>();
  for_each_index(seen_.size(), [&](std::size_t i) {
    const Eigen::Vector3f p = T * mesh_.positions_m[i], normal = T.linear() * normals_[i];
    seen_[i] = {p, normal, view.out_of_sight(p, normal)};
  });
}

/// What the mesh's colours are to the picture's, channel by channel. Sums, not single ratios: the mesh is blurred, and
/// blurring keeps sums of light.
LinearColour TextureBaker::gain_of(const PosedPicture& view) const {
  if (mesh_.colours.empty()) return {1, 1, 1};
  const std::size_t step = std::max<std::size_t>(1, seen_.size() / kCompared);
  std::array<double, 3> of_mesh{}, of_picture{};
  std::size_t compared = 0;
  for (std::size_t i = 0; i < seen_.size(); i += step) {
    const auto sight = view.look_at(seen_[i].p, seen_[i].normal);
    if (!sight) continue;
    const LinearColour picture = view.colour(*sight);
    const Rgb8 c = mesh_.colours[i];
    const LinearColour mesh = {linear(c.r), linear(c.g), linear(c.b)};
    const auto is_usable = [](const LinearColour& colour) {
      const auto [low, high] = std::minmax({colour[0], colour[1], colour[2]});
      return low > kDarkest && high < kBrightest;
    };
    if (!is_usable(picture) || !is_usable(mesh)) continue;
    ++compared;
    for (std::size_t k = 0; k < 3; ++k) {
      of_mesh[k] += static_cast<double>(mesh[k]);
      of_picture[k] += static_cast<double>(picture[k]);
    }
  }
  if (compared < kLeastCompared) return {1, 1, 1};
  LinearColour gain{};
  for (std::size_t k = 0; k < 3; ++k) {
    gain[k] = std::clamp(static_cast<float>(of_mesh[k] / of_picture[k]), 1 / kMostGain, kMostGain);
  }
  return gain;
}

void TextureBaker::look_at(std::size_t triangle, const PosedPicture& view, const LinearColour& gain) {
  if (first_texel_[triangle] == first_texel_[triangle + 1]) return;
  const Triangle& t = atlas_.triangles[triangle];
  const std::array<const SeenVertex*, 3> v = {&seen_[atlas_.source[t[0]]], &seen_[atlas_.source[t[1]]],
                                              &seen_[atlas_.source[t[2]]]};
  if ((v[0]->out_of_sight & v[1]->out_of_sight & v[2]->out_of_sight) != 0) return;
  const auto texel_area = static_cast<float>(atlas_.texel * atlas_.texel);
  std::size_t place = first_texel_[triangle];
  for_each_texel(atlas_.corners(triangle), [&](int, int, const std::array<float, 3>& w) {
    Sights& sights = sights_[place++];
    const Eigen::Vector3f p = w[0] * v[0]->p + w[1] * v[1]->p + w[2] * v[2]->p;
    const Eigen::Vector3f normal = w[0] * v[0]->normal + w[1] * v[1]->normal + w[2] * v[2]->normal;
    const auto sight = view.look_at(p, normal);
    if (!sight) return true;
    const float quality = sight->quality * texel_area;
    if (!(quality > sights.quality.back())) return true;
    std::size_t rank = kSights - 1;
    for (; rank > 0 && quality > sights.quality[rank - 1]; --rank) {
      sights.quality[rank] = sights.quality[rank - 1];
      sights.colour[rank] = sights.colour[rank - 1];
    }
    const LinearColour colour = view.colour(*sight);
    sights.quality[rank] = quality;
    for (std::size_t k = 0; k < 3; ++k) sights.colour[rank][k] = stored(gain[k] * colour[k]);
    return true;
  });
}

void TextureBaker::add(const Frame& frame, const Pose& T_world_camera) {
  const PosedPicture view(frame, T_world_camera, band_);
  project(view);
  const LinearColour gain = gain_of(view);
  for_each_index(atlas_.triangles.size(), [&](std::size_t t) { look_at(t, view, gain); });
  ++frames_;
}

LinearColour TextureBaker::mesh_colour(std::size_t triangle, const std::array<float, 3>& weights) const {
  LinearColour sum{};
  if (mesh_.colours.empty()) return sum;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Rgb8 c = mesh_.colours[atlas_.source[atlas_.triangles[triangle][corner]]];
    sum[0] += weights[corner] * linear(c.r);
    sum[1] += weights[corner] * linear(c.g);
    sum[2] += weights[corner] * linear(c.b);
  }
  return sum;
}

LinearColour TextureBaker::mixed(const Sights& sights, const LinearColour& otherwise) const {
  const float worst = kShareOfWorst * sights.quality.back();
  float total = mesh_.colours.empty() ? 0 : kMeshWeight;
  LinearColour sum = {total * otherwise[0], total * otherwise[1], total * otherwise[2]};
  for (std::size_t i = 0; i < kSights && sights.quality[i] > 0; ++i) {
    const float weight = sights.quality[i] - worst;
    total += weight;
    for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * static_cast<float>(sights.colour[i][k]) / kFull;
  }
  for (float& channel : sum) channel /= total;
  return sum;
}

BakedTexture TextureBaker::bake() const {
  BakedTexture baked;
  baked.image = ColourImage(atlas_.width, atlas_.height);
  Image<std::uint8_t> is_covered(atlas_.width, atlas_.height, 0);
  for_each_index(atlas_.triangles.size(), [&](std::size_t t) {
    std::size_t place = first_texel_[t];
    for_each_texel(atlas_.corners(t), [&](int x, int y, const std::array<float, 3>& weights) {
      const Sights& sights = sights_[place++];
      if (mesh_.colours.empty() && !(sights.quality[0] > 0)) return true;
      const LinearColour c = mixed(sights, mesh_colour(t, weights));
      baked.image.at(x, y) = {srgb_from_linear(static_cast<double>(c[0])), srgb_from_linear(static_cast<double>(c[1])),
                              srgb_from_linear(static_cast<double>(c[2]))};
      is_covered.at(x, y) = 1;
      return true;
    });
  });
  fill_uncovered(is_covered, baked.image);
  baked.texels = sights_.size();
  baked.frames = frames_;
  const auto seen = std::count_if(sights_.begin(), sights_.end(), [](auto& s) { return s.quality[0] > 0; });
  if (!sights_.empty()) baked.seen_share = static_cast<double>(seen) / static_cast<double>(sights_.size());
  return baked;
}

}  // namespace scanknit
