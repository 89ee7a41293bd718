#include "tests/app/range_grids.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <random>

namespace scanknit {

double hills_m(double x_m, double y_m) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.02, 0.24), width(0.006, 0.02), height(-0.012, 0.012);
  double z = 0;
  for (int hill = 0; hill < 60; ++hill) {
    const double dx = x_m - place(random);
    const double dy = y_m - place(random);
    const double w = width(random);
    z += height(random) * std::exp(-(dx * dx + dy * dy) / (2 * w * w));
  }
  return z;
}

void write_hills(const std::filesystem::path& path, double first_x_m, const Pose& T_grid_world) {
  constexpr int kSide = 121;
  constexpr double kStep_m = 0.001;
  std::ofstream file(path);
  file << fmt::format(
      "ply\nformat ascii 1.0\nobj_info num_cols {0}\nobj_info num_rows {0}\nelement vertex {1}\nproperty float x\n"
      "property float y\nproperty float z\nelement range_grid {1}\nproperty list uchar int "
      "vertex_indices\nend_header\n",
      kSide, kSide * kSide);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const double x = first_x_m + column * kStep_m;
      const double y = row * kStep_m;
      const Eigen::Vector3d p = T_grid_world * Eigen::Vector3d(x, y, hills_m(x, y));
      file << fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    }
  }
  for (int cell = 0; cell < kSide * kSide; ++cell) file << "1 " << cell << "\n";
}

}  // namespace scanknit
