#include "tests/readers/reader_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "extract/extract_surface.h"

namespace scanknit::test {
namespace {

constexpr double kSpacingM = 0.0083;           // divides no length here: no sample lies on the surface
constexpr double kBallM = 0.04, kArmM = 0.02;  // radii
const Eigen::Vector3d kCentre(0.3, -0.2, 1.1);
const Eigen::Vector3d kArmLengthsM(0.2, 0.14, 0.09);

/// Signed distance from the capsule between the centre and the end of the arm along `axis`.
double arm_distance(const Eigen::Vector3d& from_centre, int axis) {
  Eigen::Vector3d across = from_centre;
  across[axis] -= std::clamp(from_centre[axis], 0.0, kArmLengthsM[axis]);
  return across.norm() - kArmM;
}

double distance(const Eigen::Vector3d& from_centre) {
  double nearest = from_centre.norm() - kBallM;
  for (int axis = 0; axis < 3; ++axis) nearest = std::min(nearest, arm_distance(from_centre, axis));
  return nearest;
}

Rgb8 colour_of(const Eigen::Vector3d& from_centre, std::size_t vertex) {
  constexpr std::array<Rgb8, 3> kArms = {Rgb8{200, 60, 40}, Rgb8{60, 180, 75}, Rgb8{40, 90, 200}};
  Rgb8 colour{3, 12, 25};  // dark, where a wrong encoding shows most
  for (int axis = 0; axis < 3; ++axis) {
    if (from_centre[axis] > 1.2 * kBallM) colour = kArms[static_cast<std::size_t>(axis)];
  }
  colour.r = static_cast<std::uint8_t>(colour.r + vertex % 50);
  colour.g = static_cast<std::uint8_t>(colour.g + vertex / 50 % 50);
  return colour;
}

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out << '(' << v.transpose() << ')';
  return out.str();
}

/// IEC 61966-2-1, once more: what is checked has its own.
double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
};

Box bounds(const std::vector<Eigen::Vector3d>& positions) {
  Box box;
  for (const Eigen::Vector3d& p : positions) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Of each vertex, the number of the one of `places` at which it lies; places.size() where it lies at none.
std::vector<std::uint32_t> places_of(const std::vector<Eigen::Vector3d>& told,
                                     const std::vector<Eigen::Vector3d>& places, double tolerance) {
  std::vector<std::uint32_t> found;
  for (const Eigen::Vector3d& p : told) {
    const auto is_here = [&](const Eigen::Vector3d& place) { return (p - place).cwiseAbs().maxCoeff() <= tolerance; };
    found.push_back(static_cast<std::uint32_t>(std::find_if(places.begin(), places.end(), is_here) - places.begin()));
  }
  return found;
}

/// The triangles in an order of their own, each beginning with its smallest corner.
std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

Eigen::Vector3d bytes_of(const Eigen::Vector3d& told, ToldColour colour) {
  Eigen::Vector3d bytes = told;
  if (colour == ToldColour::kLinear) bytes = told.unaryExpr([](double c) { return 255 * encoded(c / 255); });
  return bytes.array().round();
}

std::string colour_differences(const ToldMesh& told, const Mesh& mesh, ToldColour expected,
                               const std::vector<std::uint32_t>& vertex_of) {
  if (expected == ToldColour::kNone) return told.colours.empty() ? "" : "there are colours\n";
  if (told.colours.size() != told.positions.size()) return std::to_string(told.colours.size()) + " colours\n";
  std::size_t wrong = 0;
  std::string first;
  for (std::size_t i = 0; i < told.colours.size(); ++i) {
    const Rgb8 ours = mesh.colours[vertex_of[i]];
    const Eigen::Vector3d bytes(ours.r, ours.g, ours.b), theirs = bytes_of(told.colours[i], expected);
    if (theirs == bytes) continue;
    if (wrong++ == 0) first = text(theirs) + " (told as " + text(told.colours[i]) + ") for " + text(bytes);
  }
  return wrong == 0 ? "" : std::to_string(wrong) + " colours are wrong, the first " + first + "\n";
}

}  // namespace

Mesh jack() {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kBallM + 2 * kSpacingM);
  const Eigen::Vector3i dims = ((kArmLengthsM + 2 * margin) / kSpacingM).array().ceil().cast<int>();
  Eigen::Affine3d T_world_ijk = Eigen::Translation3d(kCentre - margin) * Eigen::Scaling(kSpacingM);
  std::vector<float> samples;
  for (int k = 0; k < dims.z(); ++k) {
    for (int j = 0; j < dims.y(); ++j) {
      for (int i = 0; i < dims.x(); ++i) {
        samples.push_back(static_cast<float>(distance(T_world_ijk * Eigen::Vector3d(i, j, k) - kCentre)));
      }
    }
  }
  ExtractConfig config;
  config.inside = InsideSide::kLow;
  Mesh mesh = extract_surface(DenseView{samples.data(), dims, T_world_ijk}, config).value().mesh;
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    mesh.colours.push_back(colour_of(mesh.positions_m[i].cast<double>() - kCentre, i));
  }
  return mesh;
}

std::string differences(const ToldMesh& told, const Mesh& mesh, const Expected& expected) {
  std::ostringstream wrong;
  const bool is_shared = expected.vertices == ToldVertices::kShared;
  const std::size_t vertices = expected.count.value_or(is_shared ? mesh.positions_m.size() : 3 * mesh.triangles.size());
  const bool may_be_any = expected.vertices == ToldVertices::kAny && !expected.count;
  if (told.positions.size() != vertices && !may_be_any)
    wrong << told.positions.size() << " vertices, not " << vertices << '\n';
  if (told.triangles.size() != mesh.triangles.size()) {
    wrong << told.triangles.size() << " triangles, not " << mesh.triangles.size() << '\n';
  }
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    places.emplace_back(expected.R_told_world * p.cast<double>() / expected.unit_m);
  }
  const std::vector<std::uint32_t> vertex_of =
      places_of(told.positions, places, expected.tolerance_m / expected.unit_m);
  if (std::find(vertex_of.begin(), vertex_of.end(), places.size()) != vertex_of.end()) {
    const Box box = bounds(told.positions), ours = bounds(places);
    wrong << "vertices lie elsewhere: from " << text(box.low) << " to " << text(box.high) << ", not from "
          << text(ours.low) << " to " << text(ours.high) << '\n';
    return wrong.str();
  }
  std::vector<Triangle> triangles = told.triangles;
  for (Triangle& t : triangles) {
    for (std::uint32_t& corner : t) corner = vertex_of.at(corner);
  }
  if (sorted(triangles) != sorted(mesh.triangles)) wrong << "the triangles are others, or turned inside out\n";
  wrong << colour_differences(told, mesh, expected.colour, vertex_of);
  return wrong.str();
}

}  // namespace scanknit::test
