#include "measure/turns.h"

#include <array>
#include <cstddef>
#include <numbers>

namespace scanknit {

std::vector<Eigen::Quaterniond> icosahedral_rotations() {
  std::vector<std::array<double, 4>> vertices;
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<double, 4> unit = {0, 0, 0, 0};
    unit[i] = 1;
    vertices.push_back(unit);
  }
  for (int signs = 0; signs < 8; ++signs) {
    const auto half = [signs](int bit) { return (signs >> bit & 1) != 0 ? -0.5 : 0.5; };
    vertices.push_back({0.5, half(0), half(1), half(2)});
  }
  const double a = std::numbers::phi / 2, b = 0.5, c = 1 / (2 * std::numbers::phi);
  constexpr int kEvenPermutations[12][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 0, 3, 2},
                                            {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 0, 1, 3}, {2, 1, 3, 0},
                                            {2, 3, 0, 1}, {3, 0, 2, 1}, {3, 1, 0, 2}, {3, 2, 1, 0}};
  for (const auto& permutation : kEvenPermutations) {
    for (int signs = 0; signs < 4; ++signs) {  // the sign of the first number is that of the quaternion
      const std::array<double, 4> numbers = {a, (signs & 1) != 0 ? -b : b, (signs & 2) != 0 ? -c : c, 0};
      std::array<double, 4> vertex = {0, 0, 0, 0};
      for (std::size_t i = 0; i < 4; ++i) vertex[static_cast<std::size_t>(permutation[i])] = numbers[i];
      vertices.push_back(vertex);
    }
  }
  std::vector<Eigen::Quaterniond> rotations;
  for (const auto& [w, x, y, z] : vertices) rotations.emplace_back(w, x, y, z);
  return rotations;
}

}  // namespace scanknit
