#include "tests/usb/emulated/desk_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "acquire/convert/picture_files.h"
#include "synth/render.h"
#include "synth/synthetic_source.h"
#include "tests/app/program.h"

namespace scanknit::test {
namespace {

SynthConfig config(int steps) {
  SynthConfig config;
  config.frames = steps;
  config.intrinsics = emulated_intrinsics();
  return config;
}

/// ITU-R BT.601 in video range; two pixels share their chroma.
std::vector<std::byte> yuyv(const ColourImage& image) {
  std::vector<std::byte> bytes;
  const auto byte = [](double value) { return static_cast<std::byte>(std::lround(value)); };
  for (std::size_t i = 0; i + 1 < image.size(); i += 2) {
    const Rgb8 a = image.pixels()[i], b = image.pixels()[i + 1];
    const auto luma = [](Rgb8 p) { return 16 + (65.481 * p.r + 128.553 * p.g + 24.966 * p.b) / 255; };
    const double r = (a.r + b.r) / 510.0, g = (a.g + b.g) / 510.0, blue = (a.b + b.b) / 510.0;
    const double u = 128 - 37.797 * r - 74.203 * g + 112 * blue, v = 128 + 112 * r - 93.786 * g - 18.214 * blue;
    bytes.insert(bytes.end(), {byte(luma(a)), byte(u), byte(luma(b)), byte(v)});
  }
  return bytes;
}

std::vector<std::byte> jpeg(const ColourImage& image) {
  const TempFolder folder;
  EXPECT_TRUE(write_colour_jpeg(image, folder / "picture.jpg"));
  const std::string text = read_text(folder / "picture.jpg");
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

CameraIntrinsics emulated_intrinsics() {
  return {640, 480, 380, 381, 319, 241};  // realsense_bytes.h
}

std::vector<std::byte> depth_bytes(const DepthImage& depth_m) {
  std::vector<std::byte> bytes(2 * depth_m.size());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const auto millimetres = static_cast<std::uint16_t>(std::lround(1000 * depth_m.pixels()[i]));
    std::memcpy(bytes.data() + 2 * i, &millimetres, 2);
  }
  return bytes;
}

DeskView::DeskView(int steps, int pictures, int first)
    : scene_(make_scene("desk").value()), poses_(camera_path(*scene_, steps)), first_(static_cast<std::size_t>(first)) {
  const SyntheticScanner scanner(*scene_, config(steps));
  for (int n = 0; n < pictures; ++n) {
    pictures_.push_back(depth_bytes(scanner.shoot(first_ + static_cast<std::size_t>(n)).depth_m));
  }
}

std::vector<std::byte> DeskView::picture(std::uint64_t n) const {
  return pictures_[std::min<std::size_t>(n, pictures_.size() - 1)];
}

std::vector<std::vector<std::byte>> DeskView::colour(const CameraIntrinsics& camera, const Pose& T_colour_depth,
                                                     PixelFormat format) const {
  std::vector<std::vector<std::byte>> pictures;
  for (std::size_t n = 0; n < pictures_.size(); ++n) {
    const Pose T_world_colour = pose(n) * T_colour_depth.inverse();
    const ColourImage colour = render(*scene_, camera, T_world_colour).colour;
    pictures.push_back(format == PixelFormat::kMjpeg ? jpeg(colour) : yuyv(colour));
  }
  return pictures;
}

const DeskView& desk_view() {
  static const DeskView view(600, kPictures);
  return view;
}

const DeskView& slow_desk_view() {
  static const DeskView view(6000, kSlowPictures);
  return view;
}

VcamOptions camera_at(const DeskView& view) {
  VcamOptions options;
  options.has_colour = false;
  options.depth_picture = [&view](std::uint64_t n) { return view.picture(n); };
  return options;
}

}  // namespace scanknit::test
