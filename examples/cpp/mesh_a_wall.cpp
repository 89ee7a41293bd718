// The main job through the libraries: a flat wall seen once becomes a mesh.
#include <iostream>

#include "acquire/depth_filter.h"
#include "acquire/frame_source.h"
#include "export/write_mesh.h"
#include "extract/extract_surface.h"
#include "fusion/integrate.h"
#include "fusion/tsdf_volume.h"

int main() {
  scanknit::Frame frame;
  frame.intrinsics = {160, 120, 130, 130, 79.5, 59.5};
  frame.depth_m = scanknit::DepthImage(160, 120, 1.0f);
  scanknit::filter_frame(frame, scanknit::AcquireConfig{}, scanknit::NoiseModel{});

  auto volume = scanknit::TsdfVolume::create({.voxel_size_m = 0.02});
  if (!volume || !scanknit::integrate(frame, scanknit::Pose::Identity(), *volume)) return 1;
  scanknit::FieldView view;
  view.field = &volume->tsdf();
  view.weight_codes = &volume->weight();
  const auto surface = scanknit::extract_surface(view, {});
  if (!surface || surface->mesh.empty()) return 1;
  const auto written = scanknit::write_mesh(surface->mesh, "wall.glb", {}, scanknit::UpAxis::kMinusY);
  if (!written) {
    std::cerr << written.error().text() << '\n';
    return 1;
  }
  return scanknit::open_recording("nothing here", {}) ? 1 : 0;
}
