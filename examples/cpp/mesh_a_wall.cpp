// The main job through the libraries: frame, volume, surface, file. A flat wall, 1 m away, seen once.
//
//   cmake -S . -B build && cmake --build build && build/mesh_a_wall wall.glb
// or
//   c++ -std=c++20 mesh_a_wall.cpp -o mesh_a_wall $(pkg-config --cflags --libs scanknit) && ./mesh_a_wall wall.glb
#include <cstdio>
#include <filesystem>

#include "acquire/filter/depth_filter.h"
#include "export/mesh/write_mesh.h"
#include "extract/extract_surface.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/tsdf_volume.h"

namespace {

/// What a scanner would give: z-depth in metres, one value a pixel; 0 where nothing came back.
scanknit::Frame look_at_the_wall() {
  scanknit::Frame frame;
  frame.intrinsics = {.width = 160, .height = 120, .fx = 130, .fy = 130, .cx = 79.5, .cy = 59.5};
  frame.depth_m = scanknit::DepthImage(160, 120, 1.0f);
  return frame;
}

/// Says the error, if there is one. Nothing in these libraries throws, prints or exits.
template <typename Outcome>
bool is_good(const Outcome& outcome) {
  if (!outcome) std::fprintf(stderr, "%s\n", outcome.error().text().c_str());
  return static_cast<bool>(outcome);
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path file = argc > 1 ? argv[1] : "wall.glb";

  auto volume = scanknit::TsdfVolume::create({.voxel_size_m = 0.02});
  if (!is_good(volume)) return 1;

  // For each frame: mask what is smeared, estimate normals, fuse. The pose is camera-to-world.
  scanknit::Frame frame = look_at_the_wall();
  if (!is_good(scanknit::filter_frame(frame, scanknit::AcquireConfig{}, scanknit::NoiseModel{}))) return 1;
  if (!is_good(scanknit::integrate(frame, scanknit::Pose::Identity(), *volume))) return 1;

  // The surface lies where the signed distance is 0. Voxels that nothing has seen leave an open border.
  const auto surface = scanknit::extract_surface(volume->field_view(), {});
  if (!is_good(surface)) return 1;

  // The camera's y axis points down, so up is -Y.
  if (!is_good(scanknit::write_mesh(surface->mesh, file, {}, scanknit::UpAxis::kMinusY))) return 1;
  std::printf("%s: %zu triangles\n", file.c_str(), surface->mesh.triangles.size());
  return surface->mesh.empty() ? 1 : 0;
}
