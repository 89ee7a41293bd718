// Measures depth pictures as they are, to compare the synthetic scanner's sensors with real ones: how many pixels have
// depth, how far they are from planes by distance, over how many pixels that error is alike, and what lies beside
// depth steps.
//   measure_depth RECORDING...      real or synthetic; one that is not there is SKIPPED
#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "acquire/frame_source.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostFrames = 40;
constexpr std::array<double, 8> kBins_m = {0.3, 0.6, 1, 1.5, 2, 3, 4.5, 8};
constexpr std::array<int, 4> kLags_px = {1, 2, 4, 8};

struct Window {
  double depth_m;
  double rms_m;
  std::array<double, kLags_px.size()> correlation;  ///< of errors so far apart in a row
};

struct Measures {
  double pixels = 0, valid = 0;
  std::vector<Window> small, large;  ///< of 9 and of 33 pixels
  // At steps of more than 10 % between neighbours in a row that have depth: by which side the object is on.
  double steps_right = 0, steps_left = 0, holes_right_px = 0, holes_left_px = 0;
  double flying = 0;  ///< single pixels between both depths, one or two before a step
};

/// The errors of a window's pixels from the plane that fits best; a plane is linear in inverse depth. Nothing unless
/// all pixels have depth and lie within 5 % of it.
std::optional<Window> fit_plane(const DepthImage& depth_m, int left, int top, int side) {
  const int count = side * side;
  Eigen::MatrixX3d design(count, 3);
  Eigen::VectorXd inverse(count);
  for (int i = 0; i < count; ++i) {
    const float z = depth_m.at(left + i % side, top + i / side);
    if (!(z > 0)) return std::nullopt;
    design.row(i) << 1, i % side - side / 2, i / side - side / 2;
    inverse[i] = 1 / static_cast<double>(z);
  }
  // The design is the same for all windows and orthogonal: its normal equations are diagonal.
  const Eigen::Vector3d plane =
      (design.transpose() * inverse).cwiseQuotient(design.colwise().squaredNorm().transpose());
  const Eigen::VectorXd error = inverse - design * plane;
  if (error.cwiseAbs().maxCoeff() > 0.05 * plane[0]) return std::nullopt;
  Window window{1 / plane[0], std::sqrt(error.squaredNorm() / (count - 3)) / (plane[0] * plane[0]), {}};
  for (std::size_t k = 0; k < kLags_px.size(); ++k) {
    double sum = 0;
    int pairs = 0;
    for (int i = 0; i + kLags_px[k] < count; ++i) {
      if (i % side + kLags_px[k] >= side) continue;
      sum += error[i] * error[i + kLags_px[k]];
      ++pairs;
    }
    const double variance = error.squaredNorm() / count;
    window.correlation[k] = pairs > 0 && variance > 0 ? sum / pairs / variance : 0;
  }
  return window;
}

void measure_windows(const DepthImage& depth_m, int side, std::vector<Window>& windows) {
  for (int top = 0; top + side <= depth_m.height(); top += side) {
    for (int left = 0; left + side <= depth_m.width(); left += side) {
      if (const auto window = fit_plane(depth_m, left, top, side)) windows.push_back(*window);
    }
  }
}

void measure_row(std::span<const float> row, Measures& measures) {
  constexpr double kStep = 0.10;
  constexpr int kWidest_px = 60;
  int last = -1;
  for (int x = 0; x < static_cast<int>(row.size()); ++x) {
    const auto z = static_cast<double>(row[static_cast<std::size_t>(x)]);
    if (!(z > 0)) continue;
    const auto before = last < 0 ? z : static_cast<double>(row[static_cast<std::size_t>(last)]);
    const int holes = x - last - 1;
    if (std::abs(z - before) > kStep * std::min(z, before) && holes <= kWidest_px) {
      (z < before ? measures.steps_right : measures.steps_left) += 1;
      (z < before ? measures.holes_right_px : measures.holes_left_px) += holes;
      const auto after =
          x + 1 < static_cast<int>(row.size()) ? static_cast<double>(row[static_cast<std::size_t>(x) + 1]) : 0;
      const bool is_between = after > 0 && (after - z) * (z - before) > 0;
      if (is_between && std::abs(after - z) > kStep * std::min(z, after)) measures.flying += 1;
    }
    last = x;
  }
}

void measure(const DepthImage& depth_m, Measures& measures) {
  measures.pixels += static_cast<double>(depth_m.size());
  measures.valid += static_cast<double>(
      std::count_if(depth_m.pixels().begin(), depth_m.pixels().end(), [](float z) { return z > 0; }));
  measure_windows(depth_m, 9, measures.small);
  measure_windows(depth_m, 33, measures.large);
  for (int y = 0; y < depth_m.height(); ++y) measure_row(depth_m.row(y), measures);
}

Result<Measures> measure_recording(const std::string& recording) {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;                                  // frames without a pose count as well
  config.min_confidence = 0;                                        // depth as the sensor gives it
  config.intrinsics = CameraModel{{0, 0, 525, 525, 319.5, 239.5}};  // not used, but some recordings state none
  auto source = open_recording(recording, config);
  if (!source) return source.error();
  const std::size_t every = std::max<std::size_t>(1, (*source)->info().frames / kMostFrames);
  Measures measures;
  for (std::size_t number = 0;; ++number) {
    FrameEvent event = (*source)->next(std::stop_token{});
    if (std::holds_alternative<EndOfStream>(event)) return measures;
    if (auto* error = std::get_if<Error>(&event)) return *std::move(error);
    if (const auto* frame = std::get_if<Frame>(&event); frame && number % every == 0) measure(frame->depth_m, measures);
  }
}

/// The quarter of the windows that is nearest to planes: most others are not planes.
std::string noise_text(std::vector<Window> windows, double from_m, double to_m) {
  std::erase_if(windows, [=](const Window& w) { return w.depth_m < from_m || w.depth_m >= to_m; });
  if (windows.size() < 40) return "-";
  std::sort(windows.begin(), windows.end(), [](const Window& a, const Window& b) { return a.rms_m < b.rms_m; });
  return fmt::format("{:.2f}", 1000 * windows[windows.size() / 4].rms_m);
}

std::string correlation_text(std::vector<Window> windows) {
  if (windows.size() < 40) return "-";
  std::sort(windows.begin(), windows.end(), [](const Window& a, const Window& b) { return a.rms_m < b.rms_m; });
  windows.resize(windows.size() / 4);
  std::string text;
  for (std::size_t k = 0; k < kLags_px.size(); ++k) {
    double sum = 0;
    for (const Window& window : windows) sum += window.correlation[k];
    text += fmt::format("{}{:.2f}", k > 0 ? " / " : "", sum / static_cast<double>(windows.size()));
  }
  return text;
}

void print(const std::string& recording, const Measures& m) {
  fmt::print("{}\n  pixels with depth {:.1f} %\n", recording, 100 * m.valid / m.pixels);
  for (std::size_t i = 0; i + 1 < kBins_m.size(); ++i) {
    fmt::print("  {} to {} m: distance from planes of 9 px {} mm, of 33 px {} mm\n", kBins_m[i], kBins_m[i + 1],
               noise_text(m.small, kBins_m[i], kBins_m[i + 1]), noise_text(m.large, kBins_m[i], kBins_m[i + 1]));
  }
  fmt::print("  correlation of that distance 1 / 2 / 4 / 8 px apart (33 px): {}\n", correlation_text(m.large));
  fmt::print("  holes at a step: {:.1f} px at the left of objects, {:.1f} px at their right; flying pixels {:.1f} %\n",
             m.holes_right_px / std::max(1.0, m.steps_right), m.holes_left_px / std::max(1.0, m.steps_left),
             100 * m.flying / std::max(1.0, m.steps_right + m.steps_left));
}

int measure_all(int count, char** arguments) {
  if (count < 2) {
    fmt::print(stderr, "usage: measure_depth RECORDING...\n");
    return 2;
  }
  for (int i = 1; i < count; ++i) {
    const std::string recording = arguments[i];
    if (!std::filesystem::exists(recording)) {
      fmt::print("SKIPPED: {} is not there\n", recording);
      continue;
    }
    const auto measures = measure_recording(recording);
    if (!measures) {
      fmt::print(stderr, "{}\n", measures.error().text());
      return 4;
    }
    print(recording, *measures);
  }
  return 0;
}

}  // namespace
}  // namespace scanknit

int main(int count, char** arguments) {
  return scanknit::measure_all(count, arguments);
}
