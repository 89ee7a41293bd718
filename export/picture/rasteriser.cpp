#include "export/picture/rasteriser.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/median.h"
#include "core/mesh/mesh_area.h"

namespace scanknit {
namespace {

constexpr int kSamples = 2;          // along each side of a pixel
constexpr int kSubpixels = 16;       // fixed point: exact edge tests leave no cracks between neighbours
constexpr float kMaxScreen = 65536;  // samples; beyond it a triangle is a stray one, and products would overflow
constexpr double kHalfFieldOfView = 17.5 * std::numbers::pi / 180;  // of the shorter side: little distortion
constexpr double kMargin = 1.04;
constexpr float kAmbient = 0.4f;  // what a surface seen edge-on keeps of its colour; the lamp gives the rest

/// The camera's axes (x right, y down, z forward) and where it stands.
struct Camera {
  Eigen::Matrix3d R_camera_world;
  Eigen::Vector3d position_m;
  double focal_px = 1;
  double cx = 0, cy = 0;
  double near_m = 0;
};

/// Looking at one vertex in this many is enough to see where the mesh is.
std::size_t sampling_step(const Mesh& mesh) {
  constexpr std::size_t kEnoughVertices = 100'000;
  return mesh.positions_m.size() / kEnoughVertices + 1;
}

Camera place_camera(const Mesh& mesh, const Framing& frame, const View& view, int width, int height) {
  Camera camera;
  const Eigen::Vector3d right = view.forward.cross(view.up).normalized();
  camera.R_camera_world << right.transpose(), view.forward.cross(right).transpose(), view.forward.transpose();
  camera.focal_px = std::min(width, height) / (2 * std::tan(kHalfFieldOfView));
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;

  // The distance at which each vertex of the box falls inside the picture: |x| f / (distance + z) <= width / 2.
  const Eigen::Vector3d centre = (frame.min_m + frame.max_m) / 2;
  const std::size_t step = sampling_step(mesh);
  double distance_m = 0;
  for (std::size_t i = 0; i < mesh.positions_m.size(); i += step) {
    const Eigen::Vector3d p = mesh.positions_m[i].cast<double>();
    if ((p.array() < frame.min_m.array()).any() || (p.array() > frame.max_m.array()).any()) continue;
    const Eigen::Vector3d q = camera.R_camera_world * (p - centre);
    const double sideways = std::max(std::abs(q.x()) / (width / 2.0), std::abs(q.y()) / (height / 2.0));
    distance_m = std::max(distance_m, kMargin * sideways * camera.focal_px - q.z());
  }
  camera.position_m = centre - distance_m * view.forward;
  camera.near_m = 0.01 * distance_m;
  return camera;
}

/// A vertex on the screen. `x`, `y` count subpixels; `inverse_z` is 0 when the vertex cannot be drawn.
struct ScreenVertex {
  std::int32_t x = 0, y = 0;
  float inverse_z = 0;
  float light = 1;
};

std::vector<ScreenVertex> project(const Mesh& mesh, const Camera& camera) {
  const Eigen::Matrix3f R = camera.R_camera_world.cast<float>();
  const Eigen::Vector3f eye = camera.position_m.cast<float>();
  const auto focal = static_cast<float>(camera.focal_px);
  const auto cx = static_cast<float>(camera.cx);
  const auto cy = static_cast<float>(camera.cy);
  std::vector<ScreenVertex> screen(mesh.positions_m.size());
  for (std::size_t i = 0; i < screen.size(); ++i) {
    const Eigen::Vector3f to_vertex = mesh.positions_m[i] - eye;
    const Eigen::Vector3f p = R * to_vertex;
    if (!(p.z() > static_cast<float>(camera.near_m))) continue;
    const float x = focal * p.x() / p.z() + cx;
    const float y = focal * p.y() / p.z() + cy;
    if (!(std::abs(x) < kMaxScreen && std::abs(y) < kMaxScreen)) continue;
    screen[i].x = static_cast<std::int32_t>(std::floor(x * kSubpixels + 0.5f));
    screen[i].y = static_cast<std::int32_t>(std::floor(y * kSubpixels + 0.5f));
    screen[i].inverse_z = 1 / p.z();
    if (!mesh.normals.empty()) {
      const float cosine = std::abs(mesh.normals[i].dot(to_vertex)) / to_vertex.norm();
      screen[i].light = kAmbient + (1 - kAmbient) * std::min(cosine, 1.0f);
    }
  }
  return screen;
}

/// Twice the signed area of (a, b, p) in subpixels; with y down, positive when p is clockwise, that is right, of a->b.
std::int64_t edge(const ScreenVertex& a, const ScreenVertex& b, std::int64_t x, std::int64_t y) {
  return static_cast<std::int64_t>(b.x - a.x) * (y - a.y) - static_cast<std::int64_t>(b.y - a.y) * (x - a.x);
}

class Canvas {
 public:
  Canvas(const Mesh& mesh, const View& view, int width, int height)
      : mesh_(mesh),
        colours_(!view.colours.empty() ? view.colours : std::span(mesh.colours)),
        in_colour_(view.in_colour && !colours_.empty()),
        colour_(width, height, kBackground),
        inverse_z_(width, height, 0) {}

  /// `light` replaces the vertices' own when it is positive.
  void draw(const Triangle& triangle, const std::array<ScreenVertex, 3>& v, std::int64_t area, float light) {
    const auto [x_low, x_high] = std::minmax({v[0].x, v[1].x, v[2].x});
    const auto [y_low, y_high] = std::minmax({v[0].y, v[1].y, v[2].y});
    const int x0 = std::max(first_pixel(x_low), 0), x1 = std::min(last_pixel(x_high), colour_.width() - 1);
    const int y0 = std::max(first_pixel(y_low), 0), y1 = std::min(last_pixel(y_high), colour_.height() - 1);
    const float inverse_area = 1 / static_cast<float>(area);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const std::int64_t sx = static_cast<std::int64_t>(x) * kSubpixels;
        const std::int64_t sy = static_cast<std::int64_t>(y) * kSubpixels;
        const std::int64_t e0 = edge(v[1], v[2], sx, sy);
        const std::int64_t e1 = edge(v[2], v[0], sx, sy);
        const std::int64_t e2 = edge(v[0], v[1], sx, sy);
        if (e0 > 0 || e1 > 0 || e2 > 0) continue;  // edges belong to both sides: the depth test settles who wins
        // Linear in the picture: barycentric weights over depth. Dividing by 1/z makes attributes perspective-correct.
        const float w0 = static_cast<float>(e0) * inverse_area * v[0].inverse_z;
        const float w1 = static_cast<float>(e1) * inverse_area * v[1].inverse_z;
        const float w2 = static_cast<float>(e2) * inverse_area * v[2].inverse_z;
        const float inverse_z = w0 + w1 + w2;
        if (!(inverse_z > inverse_z_.at(x, y))) continue;
        inverse_z_.at(x, y) = inverse_z;
        const float lit = light > 0 ? light : (w0 * v[0].light + w1 * v[1].light + w2 * v[2].light) / inverse_z;
        colour_.at(x, y) = shade(triangle, w0 / inverse_z, w1 / inverse_z, w2 / inverse_z, lit);
      }
    }
  }

  /// Averages the samples of each pixel.
  [[nodiscard]] ColourImage resolve() const {
    ColourImage picture(colour_.width() / kSamples, colour_.height() / kSamples);
    constexpr int kCount = kSamples * kSamples;
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = 0; x < picture.width(); ++x) {
        int r = kCount / 2, g = kCount / 2, b = kCount / 2;  // rounds to nearest
        for (int sample = 0; sample < kCount; ++sample) {
          const Rgb8 c = colour_.at(kSamples * x + sample % kSamples, kSamples * y + sample / kSamples);
          r += c.r;
          g += c.g;
          b += c.b;
        }
        picture.at(x, y) = {static_cast<std::uint8_t>(r / kCount), static_cast<std::uint8_t>(g / kCount),
                            static_cast<std::uint8_t>(b / kCount)};
      }
    }
    return picture;
  }

 private:
  // The first and last pixel centre at or after, at or before a subpixel coordinate (shifts round towards minus).
  static int first_pixel(std::int32_t subpixels) { return (subpixels + kSubpixels - 1) >> 4; }
  static int last_pixel(std::int32_t subpixels) { return subpixels >> 4; }
  static_assert(kSubpixels == 1 << 4);

  [[nodiscard]] Rgb8 shade(const Triangle& triangle, float w0, float w1, float w2, float light) const {
    const auto channel = [light](float value) {
      return static_cast<std::uint8_t>(std::clamp(light * value + 0.5f, 0.0f, 255.0f));
    };
    if (!in_colour_) return {channel(kClay.r), channel(kClay.g), channel(kClay.b)};
    const Rgb8 a = colours_[triangle[0]], b = colours_[triangle[1]], c = colours_[triangle[2]];
    const auto mix = [&](std::uint8_t va, std::uint8_t vb, std::uint8_t vc) {
      return channel(w0 * static_cast<float>(va) + w1 * static_cast<float>(vb) + w2 * static_cast<float>(vc));
    };
    return {mix(a.r, b.r, c.r), mix(a.g, b.g, c.g), mix(a.b, b.b, c.b)};
  }

  const Mesh& mesh_;
  std::span<const Rgb8> colours_;
  bool in_colour_;
  ColourImage colour_;
  Image<float> inverse_z_;  // 0: nothing drawn yet
};

/// The light on a flat triangle, for meshes without normals.
float facet_light(const Mesh& mesh, const Triangle& t, const Camera& camera) {
  const Eigen::Vector3d normal = area_vector_m2(mesh, t);
  const Eigen::Vector3d to_camera = camera.position_m - mesh.positions_m[t[0]].cast<double>();
  const double length = normal.norm() * to_camera.norm();
  const double cosine = length > 0 ? std::abs(normal.dot(to_camera)) / length : 0.0;
  return kAmbient + (1 - kAmbient) * static_cast<float>(std::min(cosine, 1.0));
}

/// The values at 1 % and 99 % of one coordinate.
std::pair<float, float> percentiles(std::vector<float>& values) {
  const float low = percentile(values, 0.01);
  return {low, percentile(values, 0.99)};
}

}  // namespace

Framing framing(const Mesh& mesh) {
  constexpr float kStray = 1.5f;
  Framing frame;
  if (mesh.positions_m.empty()) return frame;
  const std::size_t step = sampling_step(mesh);
  for (int axis = 0; axis < 3; ++axis) {
    float low = mesh.positions_m.front()[axis], high = low;
    std::vector<float> sample;
    for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
      const float value = mesh.positions_m[i][axis];
      low = std::min(low, value);
      high = std::max(high, value);
      if (i % step == 0) sample.push_back(value);
    }
    const auto [p1, p99] = percentiles(sample);
    const bool has_strays = p99 > p1 && high - low > kStray * (p99 - p1);
    frame.min_m[axis] = has_strays ? p1 : low;
    frame.max_m[axis] = has_strays ? p99 : high;
  }
  return frame;
}

ColourImage render_view(const Mesh& mesh, const Framing& frame, const View& view, int width, int height) {
  Canvas canvas(mesh, view, kSamples * width, kSamples * height);
  if (mesh.empty() || width < 1 || height < 1) return canvas.resolve();
  const Camera camera = place_camera(mesh, frame, view, kSamples * width, kSamples * height);
  const std::vector<ScreenVertex> screen = project(mesh, camera);
  for (const Triangle& t : mesh.triangles) {
    const std::array<ScreenVertex, 3> v = {screen[t[0]], screen[t[1]], screen[t[2]]};
    if (v[0].inverse_z == 0 || v[1].inverse_z == 0 || v[2].inverse_z == 0) continue;
    // Counter-clockwise seen from outside is negative with y down; the rest is seen from behind, or edge-on.
    const std::int64_t area = edge(v[0], v[1], v[2].x, v[2].y);
    if (area >= 0) continue;
    canvas.draw(t, v, area, mesh.normals.empty() ? facet_light(mesh, t, camera) : 0.0f);
  }
  return canvas.resolve();
}

}  // namespace scanknit
