// What disambiguation costs: every decider over growing volumes, its time and its triangles relative to the face test
// alone, and the published claim that the chord decider is cheaper than the asymptotic one. One thread, normals off,
// the best of several rounds. `compare_deciders [largest side] [rounds]`
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "bench/noise_volume.h"
#include "extract/cell/face_decider.h"
#include "extract/extract_surface.h"

namespace scanknit {
namespace {

constexpr std::array<std::pair<const char*, Decider>, 10> kDeciders{{
    {"asymptotic", Decider::kAsymptotic},
    {"trilinear", Decider::kTrilinear},
    {"chord", Decider::kChord},
    {"knit", Decider::kKnit},
    {"fixed_high", Decider::kFixedHigh},
    {"fixed_low", Decider::kFixedLow},
    {"lorensen", Decider::kLorensen},
    {"tetra5", Decider::kTetra5},
    {"tetra6", Decider::kTetra6},
    {"tetra24", Decider::kTetra24},
}};

template <typename Work>
double best_seconds(int rounds, const Work& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

void compare_volumes(const char* name, const BenchVolume& volume, int rounds) {
  const DenseView view{volume.samples.data(), Eigen::Vector3i::Constant(volume.side), Eigen::Affine3d::Identity()};
  double seconds_of_first = 0;
  double triangles_of_first = 0;
  for (const auto& [decider_name, decider] : kDeciders) {
    ExtractConfig config;
    config.decider = decider;
    config.normals = false;
    std::size_t triangles = 0;
    const double seconds =
        best_seconds(rounds, [&] { triangles = extract_surface(view, config).value().mesh.triangles.size(); });
    if (seconds_of_first == 0) {
      seconds_of_first = seconds;
      triangles_of_first = static_cast<double>(triangles);
    }
    fmt::print("{:12} {:4}^3  {:11} {:9.2f} ms {:10} triangles   time {:6.2f} x   triangles {:5.2f} x\n", name,
               volume.side, decider_name, 1e3 * seconds, triangles, seconds / seconds_of_first,
               static_cast<double>(triangles) / triangles_of_first);
  }
}

/// The decision alone, over random ambiguous faces.
void compare_faces(std::size_t count, int rounds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> magnitude(0.01, 1);
  std::vector<FaceValues> faces(count);
  for (FaceValues& face : faces) {
    const double sign = (random() & 1) != 0 ? 1 : -1;
    face = {sign * magnitude(random), -sign * magnitude(random), sign * magnitude(random), -sign * magnitude(random)};
  }
  const auto joined_by = [&](FaceDecision (*decide)(const FaceValues&)) {
    std::size_t joined = 0;
    for (const FaceValues& face : faces) joined += decide(face) == FaceDecision::kHighsJoined ? 1 : 0;
    return joined;
  };
  std::array<std::size_t, 2> joined{};
  const double asymptotic = best_seconds(rounds, [&] { joined[0] = joined_by(&decide_face); });
  const double chord = best_seconds(rounds, [&] { joined[1] = joined_by(&decide_face_by_chord); });
  fmt::print("{:8} ambiguous faces: asymptotic {:5.2f} ns, chord {:5.2f} ns a face, {:.2f} x; {} and {} joined\n",
             count, 1e9 * asymptotic / static_cast<double>(count), 1e9 * chord / static_cast<double>(count),
             chord / asymptotic, joined[0], joined[1]);
}

}  // namespace
}  // namespace scanknit

int main(int argc, char** argv) {
  const int largest = argc > 1 ? std::atoi(argv[1]) : 128;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 3;
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  for (const std::size_t faces : {std::size_t{1000}, std::size_t{100'000}, std::size_t{10'000'000}})
    scanknit::compare_faces(faces, rounds);
  for (int side = 32; side <= largest; side *= 2) {
    scanknit::compare_volumes("smooth noise", scanknit::smooth_noise(side, 1), rounds);
    scanknit::compare_volumes("white noise", scanknit::white_noise(side, 1), rounds);
  }
  return 0;
}
