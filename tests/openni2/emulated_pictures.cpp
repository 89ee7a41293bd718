#include "tests/openni2/emulated_pictures.h"

#include <cmath>

namespace scanknit::test {
namespace {

EmulatedPicture render(const SyntheticScanner& scanner, std::size_t n) {
  const Shot shot = scanner.shoot(n);
  EmulatedPicture picture;
  picture.T_world_camera = shot.T_world_camera;
  for (const float z_m : shot.depth_m.pixels()) {
    picture.depth_mm.push_back(static_cast<std::uint16_t>(std::lround(1000 * z_m)));
  }
  for (const Rgb8& pixel : shot.exact.colour.pixels())
    picture.rgb.insert(picture.rgb.end(), {pixel.r, pixel.g, pixel.b});
  return picture;
}

std::vector<EmulatedPicture> render_all() {
  SynthConfig config;
  config.frames = 600;
  config.intrinsics = kEmulatedCamera;
  const SyntheticScanner scanner(emulated_scene(), config);
  std::vector<EmulatedPicture> pictures;
  for (std::size_t n = 0; n < kEmulatedPictures; ++n) pictures.push_back(render(scanner, n));
  return pictures;
}

}  // namespace

const SyntheticScene& emulated_scene() {
  static const std::unique_ptr<SyntheticScene> scene = make_scene("desk").value();
  return *scene;
}

const EmulatedPicture& emulated_picture(std::size_t k) {
  static const std::vector<EmulatedPicture> pictures = render_all();
  return pictures[k];
}

}  // namespace scanknit::test
