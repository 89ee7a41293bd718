#include "scan/mesh/write_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "export/mesh/write_mesh.h"
#include "export/texture/mesh_texture.h"
#include "export/texture/texel_size.h"
#include "export/texture/texture_atlas.h"
#include "export/texture/texture_baker.h"
#include "scan/frames/steady_frames.h"
#include "scan/mesh/memory_left.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostFrames = 256;  // frames that are baked: more take time and add little
constexpr int kJpegQuality = 92;
constexpr double kVisibleVoxels = 2;  // largest distance of a frame's depth from the mesh, or more by its noise

class TextureMaker {
 public:
  TextureMaker(const WrittenMesh& written, const ScanConfig& config, ScanSession& session)
      : written_(written), config_(config), poses_(steadiest(written.T_mesh_camera, kMostFrames)), session_(session) {}

  [[nodiscard]] Result<MeshTexture> make(FrameSource& source) {
    if (auto unfolded = unfold(source.info()); !unfolded) return unfolded.error();
    auto baked = bake(source);
    if (!baked) return baked.error();
    result_.frames = baked->frames;
    result_.texels = baked->texels;
    result_.seen_share = baked->seen_share;
    const bool is_png = config_.output.texture == TextureFormat::kPng;
    auto image = is_png ? encode_png(baked->image, PngEffort::kSmall) : encode_jpeg(baked->image, kJpegQuality);
    if (!image) return image.error();
    MeshTexture texture;
    for (std::size_t v = 0; v < atlas_.source.size(); ++v) texture.coordinates.push_back(atlas_.coordinate(v));
    texture.image = *std::move(image);
    texture.mime = is_png ? "image/png" : "image/jpeg";
    result_.bytes = texture.image.size();
    return texture;
  }

  /// After an error, what is known of the texture.
  [[nodiscard]] const TextureResult& result() const { return result_; }
  [[nodiscard]] Mesh unfolded_mesh() const { return atlas_.unfolded(written_.mesh); }

 private:
  [[nodiscard]] double fitting_texel(const RecordingInfo& info) const {
    const auto camera = info.colour_intrinsics ? info.colour_intrinsics : info.intrinsics;
    std::vector<Pose> poses;
    for (const auto& [sequence, pose] : poses_) poses.push_back(pose);
    const auto fitting = camera ? fitting_texel_m(written_.mesh, *camera, poses) : std::nullopt;
    return fitting.value_or(config_.fusion.voxel_size_m / 2);
  }

  [[nodiscard]] Result<void> unfold(const RecordingInfo& info) {
    AtlasRequest request;
    request.may_be_coarser = !config_.output.texel_size_m;
    request.texel = config_.output.texel_size_m ? *config_.output.texel_size_m : fitting_texel(info);
    request.max_side = config_.output.texture_size / 4 * 4;
    if (auto built = build(request); !built) return built;
    const std::size_t left_bytes = memory_left_bytes(config_.fusion.memory_budget_mib, bytes_of(written_.mesh));
    const double share = static_cast<double>(left_bytes) / static_cast<double>(TextureBaker::memory_bytes(atlas_));
    constexpr int kLeastSide = 64;  // of export.texture_size
    const int side = static_cast<int>(std::sqrt(share) * std::min(atlas_.width, atlas_.height)) / 4 * 4;
    if (share < 1 && request.may_be_coarser && side >= kLeastSide) {
      request.max_side = side;
      if (auto built = build(request); !built) return built;
    }
    result_.width = atlas_.width;
    result_.height = atlas_.height;
    result_.texel_m = atlas_.texel;
    result_.charts = atlas_.charts;
    const std::uint64_t needed_mib = TextureBaker::memory_bytes(atlas_) >> 20;
    const std::size_t left_mib = left_bytes >> 20;
    if (needed_mib <= left_mib) return {};
    return Error{ErrorCode::kBudget,
                 fmt::format("a texture of {} x {} takes {} MiB, more than the {} that are left of "
                             "fusion.memory_budget: take a smaller export.texture_size, larger texels "
                             "(export.texel_size), or a larger budget",
                             atlas_.width, atlas_.height, needed_mib, left_mib)};
  }

  [[nodiscard]] Result<void> build(const AtlasRequest& request) {
    auto atlas = build_atlas(written_.mesh, request);
    if (!atlas) return atlas.error();
    atlas_ = *std::move(atlas);
    return {};
  }

  [[nodiscard]] Result<BakedTexture> bake(FrameSource& source) {
    const FusionConfig& fusion = config_.fusion;
    TextureBaker baker(written_.mesh, atlas_,
                       {kVisibleVoxels * fusion.voxel_size_m, fusion.truncation_sigmas, fusion.noise});
    std::size_t done = 0;
    const auto read = for_each_frame(source, session_.stop(), [&](Frame& frame) -> Result<Reading> {
      const auto pose = poses_.find(frame.sequence);
      if (pose == poses_.end()) return Reading::kContinue;
      if (frame.colour) baker.add(frame, pose->second);
      session_.progress("baking the texture", ++done, poses_.size());
      return done < poses_.size() ? Reading::kContinue : Reading::kStop;
    });
    if (!read) return read.error();
    if (session_.is_stopped()) return Error{ErrorCode::kInput, "it was interrupted"};
    if (done < poses_.size()) {
      session_.warn(WarningCode::kFramesDropped,
                    fmt::format("{} of {} frames could not be read again: the texture lacks them", poses_.size() - done,
                                poses_.size()));
    }
    BakedTexture baked = baker.bake();
    if (baked.frames == 0) return Error{ErrorCode::kInput, "none of the frames has colour"};
    return baked;
  }

  const WrittenMesh& written_;
  const ScanConfig& config_;
  PosesBySequence poses_;
  ScanSession& session_;
  TextureResult result_;
  TextureAtlas atlas_;
};

std::vector<std::filesystem::path> glb_files(const ScanJob& job) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& path : job.files.meshes) {
    if (is_glb_path(path)) files.push_back(path);
  }
  return files;
}

/// Why no texture can be made; nothing: it can.
std::optional<Error> obstacle(const FrameArchive& archive, const ScanSession& session) {
  if (session.is_stopped()) return Error{ErrorCode::kInput, "it was interrupted"};
  if (!archive.is_kept()) return Error{ErrorCode::kInput, "no recording was made that frames could be taken from"};
  return std::nullopt;
}

/// The result without a texture: the GLB stays as it is.
TexturedMesh without_texture(TextureResult result, const Error& error, ScanSession& session) {
  result.refused = error.text();
  session.warn(
      WarningCode::kNoTexture,
      fmt::format("export.texture: no texture was made ({}): the GLB has colours at its vertices", error.text()));
  return {.outcome = {}, .texture = std::move(result)};
}

}  // namespace

TexturedMesh write_textured(const WrittenMesh& written, const ScanJob& job, const FrameArchive& archive,
                            ScanSession& session) {
  const ExportConfig& config = job.config.output;
  if (config.texture == TextureFormat::kOff) return {};
  const auto files = glb_files(job);
  // The user was warned of this before the work.
  if (files.empty())
    return {.outcome = {}, .texture = TextureResult{.refused = "only GLB can hold it, and none is written"}};
  if (const auto error = obstacle(archive, session)) return without_texture({}, *error, session);
  TextureMaker maker(written, job.config, session);
  const auto texture = session.timed("texture", [&]() -> Result<MeshTexture> {
    auto source = archive.open();
    return source ? maker.make(**source) : source.error();
  });
  if (!texture) return without_texture(maker.result(), texture.error(), session);
  const Mesh mesh = maker.unfolded_mesh();
  TexturedMesh textured{.outcome = {}, .texture = maker.result()};
  for (const std::filesystem::path& path : files) {
    const auto rewritten = session.timed(
        "export", [&] { return write_mesh(mesh, path, config, written.world_up, std::nullopt, &*texture); });
    if (!rewritten) textured.outcome = rewritten.error();
    if (!rewritten) break;
  }
  return textured;
}

}  // namespace scanknit
